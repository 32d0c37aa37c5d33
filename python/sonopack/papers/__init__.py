"""Reproduction of published papers: `sonopack reproduce`.

The published values, and the claims made in words, are tables beside the code that computes our values: somfai/*.tsv of
E. Somfai, J.-N. Roux, J. H. Snoeijer, M. van Hecke, W. van Saarloos, Phys. Rev. E 72, 021301 (2005), and blackmore/*.tsv of
D. Blackmore, A. Rosato, X. Tricoche, K. Urban, V. Ratnaswamy, J. Mech. Mater. Struct. 6 (2011). A row has a quantity, a
relation, a value, how sharply it is meant, and its place in the paper.
"""
