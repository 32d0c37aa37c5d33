"""test_gallery.py with the commands of all pages.

usage: test_gallery_long.py COMMAND SOURCE_DIR
"""
import test_gallery

test_gallery.main(every=1)
