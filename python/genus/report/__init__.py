"""Error against run time: tables, measurements and plots."""
