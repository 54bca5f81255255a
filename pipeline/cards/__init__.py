"""Cards of datasets and models: rendered from what is stored and measured, nothing by hand."""
