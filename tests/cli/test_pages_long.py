"""The commands of the other pages work as written: cli.test_readme has those of the README and of the guide.

usage: test_pages_long.py COMMAND SOURCE_DIR
"""
from test_readme import PAGES, SOURCE, console_commands, run_pages

OTHERS = [str(page.relative_to(SOURCE)) for page in sorted(SOURCE.glob("docs/*.md"))]
run_pages([page for page in OTHERS if page not in PAGES and console_commands((SOURCE / page).read_text())])
