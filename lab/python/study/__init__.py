"""What the study of selection rules is made of: bodies and their images, carrying, rules, and cross-validation."""
