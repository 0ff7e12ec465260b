"""Planning times against the published transcription: the table of docs/performance.md."""
