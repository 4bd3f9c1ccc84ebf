"""Tables of sweeps as files: CSV, workbooks and folders of Parquet files, which appear whole."""
