"""The report: what came out, in sentences, tables and figures."""
