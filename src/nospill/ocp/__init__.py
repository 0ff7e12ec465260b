"""The optimal control problem: a scene as a nonlinear programme, and a solved one as exported samples."""
