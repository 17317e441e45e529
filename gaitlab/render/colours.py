"""Colours of what is drawn over a picture; they differ in lightness too, for grey printers.

References:
    Okabe2008: M. Okabe and K. Ito, Color Universal Design: how to make figures and presentations
        that are friendly to colorblind people, 2008.
"""

BLUE, VERMILLION = "#0072B2", "#D55E00"  # [Okabe2008]
INK, FAINT, PAPER = "#222222", "#BBBBBB", "#FFFFFF"
