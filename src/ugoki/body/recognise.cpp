#include "ugoki/body/recognise.h"

#include "ugoki/body/recogniser.h"

namespace ugoki::body {

Character recognise_character(const MeasuredMotion& motion, const AnatomyMapping* correction) {
  return Recogniser(motion, correction).run();
}

}  // namespace ugoki::body
