"""A paper's findings predicted anew: several experiments whose results share one page.

`document` reads the file of a reproduction, `page` writes its page. `sections` holds a file for
each kind of section, `section` what each of them is given. Beside the paper stand `answers`, the
cells that answer to printed ones and the order of the grounds, and `efficiency`; `headline` says it
in three lines. `together` shows variants of several experiments as one, `swept` is what a designed
sweep found.
"""

from gaitlab.papers.reproduction.document import Reproduction, load_reproduction, sweep_page
from gaitlab.papers.reproduction.page import write_reproduction

__all__ = [
    "Reproduction",
    "load_reproduction",
    "sweep_page",
    "write_reproduction",
]
