"""Answers: facts, tables and notes, made once, and written as text, JSON or a page."""
