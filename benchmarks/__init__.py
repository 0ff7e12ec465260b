"""Planning times, a campaign of random tasks, reasons of failures, and the slosh model against measurements."""
