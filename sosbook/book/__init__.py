"""The book's own tools; nothing else imports them."""
