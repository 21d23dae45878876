#pragma once
// Sample content of the project's own making: a human, a dog, a ball, their motions, and a first scenario of 20 s.

#include <string>

#include "ugoki/content/generate.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::samples {

/// A scenario document (docs/scenario.md) with the mechanisms and motions that it names; names for people are
/// Mechanism::name() and Motion::name.
struct Sample {
  std::string document;          ///< JSON text
  content::Resources resources;  ///< "human", "dog", "ball"; "human-walk", "human-stand", "dog-trot", "dog-stand"
};

/// A human walks across the park, a dog trots beside; somebody throws a light ball at the human's chest, which bounces
/// off; the human sways and walks on. The same bits on every machine.
[[nodiscard]] Sample make_sample();

/// The human's skeleton (1.75 m, T position, proportions of Drillis and Contini) walking at 1.35 m/s; one stride, cyclic.
[[nodiscard]] MeasuredMotion make_human_walk();
/// The same human standing at ease; 4 s, cyclic.
[[nodiscard]] MeasuredMotion make_human_stand();

/// A person of this height [m], all joints free to move within human ranges, knees and elbows hinges; in the T position. Below 1.6 m
/// proportions and mass are those of a child whose median height this is. Errors: a height that no growth reaches.
[[nodiscard]] Result<MechanismPtr> make_person(double height);

/// A shepherd dog, 0.62 m at the withers, 32 kg. In the neutral position it stands, paws on z = 0, below its root's x, y.
[[nodiscard]] MechanismPtr make_dog();
/// The dog trotting at 1.35 m/s, diagonal legs together; one stride, cyclic.
[[nodiscard]] Motion make_dog_trot(const Mechanism& dog);
/// The dog standing; 4 s, cyclic.
[[nodiscard]] Motion make_dog_stand(const Mechanism& dog);

/// A light ball: radius 0.11 m, 0.35 kg; its origin is its centre.
[[nodiscard]] MechanismPtr make_ball();

}  // namespace ugoki::samples
