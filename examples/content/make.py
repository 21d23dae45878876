#!/usr/bin/env python3
"""Makes the contents of this folder that follow from formulas: linkages, robots, circuits, people. Run it in this folder."""
from recipes.bicycle import cycling
from recipes.carrying import carrying
from recipes.circuits import fmu, oscillator, own_controller
from recipes.common import write
from recipes.doll import doll
from recipes.linkages import andrews, five_bar, jansen
from recipes.people import band, bar, game, natural, paths, push_test, rag_dolls, retargeting, rider
from recipes.riding import riding

if __name__ == "__main__":
    for made in (jansen, andrews, five_bar, band, own_controller, push_test, rag_dolls, bar, rider, retargeting, paths, natural, game, fmu, cycling, carrying, riding, doll):
        name = {"own_controller": "own-lsi", "push_test": "push-test", "rag_dolls": "rag-dolls", "five_bar": "five-bar", "cycling": "cyclist", "carrying": "box-by-two", "riding": "riding"}.get(made.__name__, made.__name__)
        write(name, made())
    write("../fmu/oscillator", {"version": 2, **oscillator()})
