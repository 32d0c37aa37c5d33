"""The commands of more pages work as written: cli.test_readme has those of the README and of the guide.

usage: test_pages.py COMMAND SOURCE_DIR
"""
from test_readme import run_pages

run_pages([f"docs/{page}.md" for page in ("view", "figures", "formats", "sensitivity", "uncertainty", "design-waves", "coda", "traces")])
