#pragma once
// Chains for tests: mechanisms whose links follow one another.

#include <string>
#include <utility>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::testing {

/// A chain of `links` links, named link0, link1, ...; the parent of a link is the link before it.
/// @param describe describe(i, link) sets the joint, the inertia and the shapes of link i
template <class Describe>
MechanismPtr make_chain(int links, const Describe& describe) {
  MechanismSpec spec;
  spec.name = "chain";
  for (int i = 0; i < links; ++i) {
    LinkSpec link;
    link.name = "link" + std::to_string(i);
    if (i > 0) link.parent = "link" + std::to_string(i - 1);
    describe(i, link);
    spec.links.push_back(std::move(link));
  }
  return Mechanism::make(std::move(spec)).value();
}

}  // namespace ugoki::testing
