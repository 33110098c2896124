"""Words and tables of the Modbus interface; nothing here knows of images."""
