"""Parameters of liquids and joints identified from recorded runs, and motions that identify them well."""
