"""The Lark grammars, installed as package data of cncgen."""
