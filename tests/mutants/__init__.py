"""Changes of the checker by rule, and whether the tests' inputs notice them."""
