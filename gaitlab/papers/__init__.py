"""Published numbers and equations of the papers, checked one by one."""
