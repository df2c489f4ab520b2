"""Six models of impacts and friction: cases.py has their exact ends, each package its own file."""
