"""Mutants of the code, drawn at random: does any test notice?"""
