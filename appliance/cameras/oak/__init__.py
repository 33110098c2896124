"""OAK cameras, through depthai."""
