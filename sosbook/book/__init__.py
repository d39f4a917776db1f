"""What only the book needs; nothing else imports it."""
