#pragma once
// A world for tests of motion operations: a human with walking motions, and a child without motions.

#include <gtest/gtest.h>

#include <memory>

#include "ugoki/body/body.h"
#include "ugoki/lsi/standard_library.h"
#include "ugoki/lsi/world.h"
#include "ugoki/motion_edit/edit.h"
#include "ugoki/samples/samples.h"

namespace ugoki::lsi {

/// The character `walker` with two clips on its track, a walk and a faster walk, and the character `child` without clips.
struct Walker {
  MechanismPtr human, child = samples::make_person(1.2).value();
  std::shared_ptr<Motion> walk, fast;
  std::unique_ptr<World> world;

  Walker() {
    const MeasuredMotion measured = samples::make_human_walk();
    const body::Body body = body::make_body(measured, {.keep_unmoved = true}).value();
    human = body.mechanism;
    walk = std::make_shared<Motion>(body::to_motion(body, measured));
    walk->cyclic = true;
    fast = std::make_shared<Motion>(motion_edit::scale(*human, *walk, {.time = 0.8}).value());
    CharacterSpec spec;
    spec.id = "walker";
    spec.mechanism = human;
    for (const auto& motion : {walk, fast}) {
      TrackClip clip;
      clip.motion = motion;
      clip.clip.start = spec.track.empty() ? 0 : 1;
      clip.clip.length = 1;
      spec.track.push_back(clip);
    }
    CharacterSpec small;
    small.id = "child";
    small.mechanism = child;
    world = std::make_unique<World>(std::vector<CharacterSpec>{std::move(spec), std::move(small)}, std::vector<ScheduledEvent>{},
                                    Vec3{0, 0, -9.81}, collision::Ground{});
  }
};

}  // namespace ugoki::lsi
