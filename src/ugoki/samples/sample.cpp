#include "ugoki/base/check.h"
#include "ugoki/body/body.h"
#include "ugoki/samples/samples.h"

namespace ugoki::samples {
namespace {

// The ball rests in front of the human. At 2.5 s it is thrown. Half a second later, at the top of its flight, it hits the chest of the
// human, who walks at 1.35 m/s. At the top the height changes little, so a human 0.1 m ahead or behind is still hit at the chest.
constexpr const char* document = R"({
  "version": 1,
  "name": "park",
  "duration": 20,
  "frame_rate": 60,
  "step": 0.002,
  "gravity": [0, 0, -9.81],
  "ground": {"height": 0, "friction": 0.9, "restitution": 0},
  "characters": [
    {
      "id": "human", "name": "Human", "mechanism": "human", "color": "#e6e6ea",
      "link_colors": {
        "Spine": "#4d7f7a", "Spine1": "#4d7f7a", "Chest": "#4d7f7a", "LeftShoulder": "#4d7f7a", "RightShoulder": "#4d7f7a", "LeftArm": "#4d7f7a", "RightArm": "#4d7f7a",
        "Hips": "#35425e", "LeftUpLeg": "#35425e", "RightUpLeg": "#35425e", "LeftLeg": "#35425e", "RightLeg": "#35425e",
        "LeftFoot": "#e8e4dc", "RightFoot": "#e8e4dc", "LeftToeBase": "#e8e4dc", "RightToeBase": "#e8e4dc",
        "Neck": "#d3a284", "Head": "#d3a284", "LeftForeArm": "#d3a284", "RightForeArm": "#d3a284", "LeftHand": "#d3a284", "RightHand": "#d3a284"
      },
      "place": {"x": 0, "y": 0, "z": 0, "heading": 0},
      "control": {"mode": "track", "tracking": 1, "balance": 1, "assist_limit": 0.5, "beyond": "release"},
      "track": [{"id": "k1", "motion": "human-walk", "start": 0, "length": 20, "offset": 0, "speed": 1, "blend": 0, "loop": true}]
    },
    {
      "id": "dog", "name": "Dog", "mechanism": "dog", "color": "#c9a57b",
      "place": {"x": 0.2, "y": -1.2, "z": 0, "heading": 0},
      "control": {"mode": "track", "tracking": 1, "balance": 1, "assist_limit": 0.5, "beyond": "release"},
      "track": [{"id": "k2", "motion": "dog-trot", "start": 0, "length": 20, "offset": 0, "speed": 1, "blend": 0, "loop": true}]
    },
    {
      "id": "ball", "name": "Ball", "mechanism": "ball", "color": "#ff8a3d",
      "place": {"x": 6.6, "y": 0.7, "z": 0.11, "heading": 0},
      "control": {"mode": "passive", "tracking": 1, "balance": 1, "assist_limit": 0.5, "beyond": "release"},
      "track": []
    }
  ],
  "events": [
    {"id": "e1", "type": "throw", "time": 2.5, "character": "ball", "from": [6.6, 0.7, 0.11], "velocity": [-5.2, -1.1, 4.85], "spin": [0, -6, 0]}
  ],
  "camera": {"follow": "human", "distance": 5, "azimuth": 0.7, "elevation": 0.2},
  "look": {"light": 0.9, "floor": "#2a2c31"},
  "circuit": null
}
)";

}  // namespace

Sample make_sample() {
  Sample out;
  out.document = document;

  const MeasuredMotion walk = make_human_walk();
  body::BodyOptions options;
  options.height = 1.75;
  options.mass = 70;
  const auto human = body::make_body(walk, options);
  UGOKI_CHECK(human.has_value());
  const auto add_motion = [&](const char* id, Motion motion) {
    motion.cyclic = true;
    out.resources.motions[id] = std::make_shared<const Motion>(std::move(motion));
  };
  out.resources.mechanisms["human"] = human->mechanism;
  add_motion("human-walk", body::to_motion(*human, walk));
  add_motion("human-stand", body::to_motion(*human, make_human_stand()));

  const MechanismPtr dog = make_dog();
  out.resources.mechanisms["dog"] = dog;
  add_motion("dog-trot", make_dog_trot(*dog));
  add_motion("dog-stand", make_dog_stand(*dog));

  out.resources.mechanisms["ball"] = make_ball();
  return out;
}

}  // namespace ugoki::samples
