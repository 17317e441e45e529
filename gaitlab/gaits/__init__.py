"""gaits"""
