"""Pictures of results files: the only code that imports matplotlib; reads results and nothing else."""
