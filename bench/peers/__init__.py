"""One adapter a peer; each gives `contenders()`, and says why where it cannot take part."""
