"""The record of a plan: folder, exports as played, approach."""
