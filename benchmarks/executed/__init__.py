"""Plans of the bundled examples as an arm would play and a recorder write them, judged by `executed`."""
