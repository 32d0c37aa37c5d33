"""test_mpi.py with every number of ranks and every way in which a job ends.

usage: test_mpi_long.py COMMAND SOURCE_DIR MPI_COMMAND
"""
import test_mpi

test_mpi.main(slow=True)
