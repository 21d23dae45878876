"""Two people carry a box between them; one is pushed."""
from recipes.person import arm_keys, reach

DISTANCE, HAND = 0.92, (0.03, 0.27, -0.14)  # m: of each person from the box; left palm in the frame of the pelvis
HEIGHT = 0.83  # m: of the box and its poles


def carrying():
    duration, speed, start, stop = 14.0, 0.75, 1.0, 9.0
    arm = reach(HAND, 0, [-1.1, 0.0, -0.3, 0.3])
    layer = {"id": "l1", "name": "Holding", "mode": "replace", "ease_in": None, "ease_out": None, "joints": arm_keys(arm)}
    pole = lambda s: {"type": "capsule", "radius": 0.018, "half_length": DISTANCE + 0.1, "position": [0, HAND[1] * s, 0], "rotation": [0.707106781, 0, 0.707106781, 0], "collides": False}
    box = {"name": "box", "joint": {"type": "floating", "position": [0, 0, 0]}, "inertia": {"mass": 40, "centre": [0, 0, 0], "about_centre": [1.4, 5.2, 6.0, 0, 0, 0]},
           "shapes": [{"type": "box", "half_extents": [0.38, 0.24, 0.16], "position": [0, 0, 0.02], "collides": False}, pole(1), pole(-1)]}
    colors = [{"Chest": "#b5483a", "Spine": "#b5483a", "Spine1": "#b5483a"}, {"Chest": "#39597d", "Spine": "#39597d", "Spine1": "#39597d"}]
    people = [{"id": i, "name": n, "mechanism": "person", "color": "#e6e6ea", "link_colors": c, "place": {"x": x, "y": 0}, "control": {"mode": "track", "assist_limit": 0},
               "track": [{"id": k, "motion": "walk", "start": 0, "length": duration, "loop": False, "layers": [layer]}]}
              for i, n, x, k, c in (("front", "In front", DISTANCE, "k1", colors[0]), ("rear", "Behind", -DISTANCE, "k2", colors[1]))]
    grip = lambda n, who, side, s: {"id": f"g{n}", "type": "grab", "time": 0, "character": who, "link": f"hand {side}", "point": [0, 0.07 * s, 0], "other": "box", "other_link": "box",
                                    "rigid": False, "limit": 500, "reach": 2}
    return {"scenario": {
        "version": 1, "name": "box by two", "duration": duration,
        "characters": people + [{"id": "box", "name": "Box, 40 kg", "mechanism": "box", "color": "#c9a57b", "place": {"x": 0, "y": 0, "z": HEIGHT}, "control": {"mode": "passive"}}],
        "events": [grip(1, "front", "left", 1), grip(2, "front", "right", -1), grip(3, "rear", "left", 1), grip(4, "rear", "right", -1),
                   {"id": "push1", "type": "push", "time": 5, "duration": 0.2, "character": "rear", "link": "chest", "force": [0, 120, 0]}],
        "markers": [{"id": "m1", "time": 5, "name": "push"}],
        "camera": {"follow": "box", "distance": 5, "azimuth": 1.2, "elevation": 0.15}},
        "mechanisms": {"person": {"person": 1.75}, "box": {"format": "ugoki-mechanism", "version": 1, "name": "box with poles", "links": [box]}},
        "motions": {"walk": {"gait": {"speed": 0, "seconds": duration, "stages": [{"time": start, "kind": "walk", "speed": speed}, {"time": stop, "kind": "walk", "speed": 0}]}, "of": "person", "name": "Walk of 5 m"}}}
