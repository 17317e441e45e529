"""Figures of a reproduction's sections: one file each."""
