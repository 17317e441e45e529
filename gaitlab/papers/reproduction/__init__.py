"""A paper's findings predicted anew: several experiments whose results share one page.

`document` reads the file of a reproduction, `page` writes its page. `sections` holds a file for
each kind of section, `section` what each of them is given, `figures` what they draw. Beside the
paper stand `answers`, the cells that answer to printed ones, `agreement_table`, how many of them
each variant meets, `gaps`, how far they lie apart, `ground_order` and `efficiency`; `headline` says
it in three lines. `together` shows variants of several experiments as one, `swept` is what a
designed sweep found, `sweep_page` the page of one.
"""

from gaitlab.papers.reproduction.document import Reproduction, load_reproduction
from gaitlab.papers.reproduction.page import write_reproduction
from gaitlab.papers.reproduction.sweep_page import sweep_page

__all__ = ["Reproduction", "load_reproduction", "sweep_page", "write_reproduction"]
