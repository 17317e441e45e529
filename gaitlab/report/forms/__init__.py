"""The forms of a page beside Markdown: one file of HTML, tables in LaTeX and CSV. No number is
made here.
"""

from gaitlab.report.forms.html import html_page, write_html
from gaitlab.report.forms.tables import write_tables

__all__ = ["html_page", "write_html", "write_tables"]
