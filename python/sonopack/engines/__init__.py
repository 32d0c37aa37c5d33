"""Beyond one machine: modes and signals by PETSc and SLEPc, on as many ranks as mpirun starts (docs/cluster.md)."""
