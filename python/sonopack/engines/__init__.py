"""Beyond one machine: modes, moduli and signals by PETSc and SLEPc, on as many ranks as mpirun starts (docs/cluster.md)."""
