"""A model as a live page: the page's own files in `page`, what is not ours in `vendor`."""
