#pragma once
// Sample content computed by the project: a human, a dog, a ball, their motions, and a first scenario of 20 s.

#include <string>

#include "ugoki/content/generate.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::samples {

/// A scenario document (docs/scenario.md) with the mechanisms and motions to which it refers. Their display names are
/// Mechanism::name() and Motion::name.
struct Sample {
  std::string document;          ///< JSON text
  content::Resources resources;  ///< "human", "dog", "ball"; "human-walk", "human-stand", "dog-trot", "dog-stand"
};

/// Scenario: a human walks across a park and a dog trots beside the human. A light ball flies at the human's chest and bounces off; the
/// human sways and keeps walking. The result is bitwise equal on every machine.
[[nodiscard]] Sample make_sample();

/// One stride of the human walking at 1.35 m/s, cyclic. Skeleton: 1.75 m, rest in the T position, proportions of Drillis and Contini.
[[nodiscard]] MeasuredMotion make_human_walk();
/// The human of make_human_walk() in quiet standing; 4 s, cyclic.
[[nodiscard]] MeasuredMotion make_human_stand();

/// A person of this height [m]. The neutral position is the T position. Knees and elbows are hinges; all joints have human limits. Below
/// 1.6 m, proportions and mass are those of a child at the age whose median height equals `height`.
/// Errors: the errors of grow(), for example a height out of its range.
[[nodiscard]] Result<MechanismPtr> make_person(double height);

/// A shepherd dog, 0.62 m at the withers, 32 kg. In the neutral position the dog stands with its paws on z = 0 and its root at x = y = 0.
[[nodiscard]] MechanismPtr make_dog();
/// One stride of the dog trotting at 1.35 m/s with diagonal legs in phase; cyclic.
[[nodiscard]] Motion make_dog_trot(const Mechanism& dog);
/// The dog standing; 4 s, cyclic.
[[nodiscard]] Motion make_dog_stand(const Mechanism& dog);

/// A light ball: radius 0.11 m, 0.35 kg; the origin of its frame is the centre.
[[nodiscard]] MechanismPtr make_ball();

}  // namespace ugoki::samples
