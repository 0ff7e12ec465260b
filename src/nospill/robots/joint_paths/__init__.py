"""From a path of the tray to paths of the joints."""
