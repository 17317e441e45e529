"""A paper's findings predicted anew: several experiments whose results share one page."""

from gaitlab.reproduction.document import Reproduction, load_reproduction
from gaitlab.reproduction.page import write_reproduction
from gaitlab.reproduction.sweep_page import sweep_page

__all__ = ["Reproduction", "load_reproduction", "sweep_page", "write_reproduction"]
