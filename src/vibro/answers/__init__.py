"""Answers: facts, tables and notes, made once, and written as text, JSON, CSV or a page."""
