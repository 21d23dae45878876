#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

#include "ugoki/base/number.h"
#include "ugoki/formats/asf.h"
#include "ugoki/formats/file_axes.h"
#include "ugoki/formats/text.h"

namespace ugoki::formats {
namespace {

class AmcReader {
 public:
  AmcReader(std::string_view text, const Asf& asf, double rate, Problems& problems)
      : scanner_(text), text_size_(text.size()), asf_(asf), rate_(rate), problems_(problems), degrees_(asf.degrees) {
    for (std::size_t i = 0; i < asf.bones.size(); ++i) {
      index_.emplace(asf.bones[i].name, i);
      first_.push_back(numbers_a_frame_);
      numbers_a_frame_ += asf.bones[i].freedoms.size();
    }
  }

  bool read() {
    while (!problems_.full() && scanner_.skip_space()) {
      const std::string_view word = scanner_.peek();
      if (word.starts_with('#')) {
        scanner_.rest_of_line();
      } else if (word.starts_with(':')) {
        if (!read_header(word)) return false;
      } else if (const char c = word[0]; (c >= '0' && c <= '9') || c == '-' || c == '+') {
        if (!begin_frame()) return false;
      } else if (!read_bone()) {
        return false;
      }
    }
    if (!problems_.empty() || !end_frame()) return false;
    if (frame_lines_.empty()) {
      problems_.add(ErrorCode::truncated, scanner_.line(), "the file holds no frames.", "Export or copy it again.");
      return false;
    }
    return true;
  }

  void evaluate(MeasuredMotion& motion) const {
    const std::size_t joints = asf_.skeleton.joints.size();
    const std::size_t frames = frame_lines_.size();
    const double angle_unit = degrees_ ? pi / 180 : 1;
    motion.rate = rate_;
    const std::size_t total = static_cast<std::size_t>(numbers_.back() - numbers_.front() + 1);
    motion.frames = static_cast<int>(total);
    motion.translations.resize(total * joints);
    motion.rotations.resize(total * joints);
    std::size_t filled = 0;
    for (std::size_t f = 0; f < frames; ++f) {
      const auto at = static_cast<std::size_t>(numbers_[f] - numbers_.front());
      evaluate_frame(values_.data() + f * numbers_a_frame_, angle_unit, motion.translations.data() + at * joints,
                     motion.rotations.data() + at * joints);
      for (; filled < at; ++filled)
        interpolate(motion, filled, f == 0 ? 0 : static_cast<std::size_t>(numbers_[f - 1] - numbers_.front()), at);
      filled = at + 1;
    }
  }

  [[nodiscard]] long missing_frames() const { return numbers_.back() - numbers_.front() + 1 - static_cast<long>(numbers_.size()); }

 private:
  bool stop(ErrorCode code, int line, std::string message, std::string remedy) {
    problems_.add(code, line, std::move(message), std::move(remedy));
    return false;
  }

  bool read_header(std::string_view word) {
    if (!frame_lines_.empty())
      return stop(ErrorCode::structure, scanner_.line(), in_quotes(word) + " stands between the frames.", "Put it before the first frame.");
    if (equal_ignoring_case(word, ":DEGREES")) degrees_ = true;
    if (equal_ignoring_case(word, ":RADIANS")) degrees_ = false;
    scanner_.rest_of_line();
    return true;
  }

  bool begin_frame() {
    if (!end_frame()) return false;
    const std::string_view word = scanner_.word();
    const int line = scanner_.line();
    const auto number = parse_long(word);
    if (!number || *number < 0 || *number > 2'000'000'000)
      return stop(ErrorCode::syntax, line, in_quotes(word) + " is no frame number.",
                  "A frame begins with its number, 0 or above, alone on a line.");
    if (const std::string_view rest = scanner_.rest_of_line(); !rest.empty() && !rest.starts_with('#'))
      return stop(ErrorCode::syntax, line, "after the frame number stands " + in_quotes(rest) + ".",
                  "A frame begins with its number alone on a line; a bone's line begins with its name.");
    if (!numbers_.empty()) {
      const long last = numbers_.back();
      if (*number <= last)
        return stop(ErrorCode::structure, line, "frame " + std::to_string(*number) + " follows frame " + std::to_string(last) + ".",
                    "Put the frames into their order, each once.");
      const double longest = std::max(1.0, rate_);
      if (static_cast<double>(*number - last - 1) > longest)
        return stop(ErrorCode::structure, line,
                    "the frames between " + std::to_string(last) + " and " + std::to_string(*number) + " are missing, more than a second.",
                    "Cut the motion in two there, or export it again.");
      missing_ += *number - last - 1;
      if (static_cast<std::uint64_t>(missing_) * asf_.bones.size() > 10'000'000 + 8 * text_size_)
        return stop(ErrorCode::range, line, "more frames are missing than are there.", "Export the motion again.");
    }
    numbers_.push_back(*number);
    frame_lines_.push_back(line);
    seen_.assign(asf_.bones.size(), 0);
    if (std::uint64_t{numbers_.size()} * asf_.bones.size() > 1'000'000 + 8 * text_size_)
      return stop(ErrorCode::range, line, "almost no bone has a freedom.", "Leave out bones that never move.");
    values_.resize(values_.size() + numbers_a_frame_, 0.0);
    return true;
  }

  bool end_frame() {
    if (frame_lines_.empty()) return true;
    for (std::size_t i = 0; i < seen_.size(); ++i) {
      if (seen_[i] || asf_.bones[i].freedoms.empty()) continue;
      const bool last = !scanner_.skip_space();
      return stop(
          last ? ErrorCode::truncated : ErrorCode::structure, frame_lines_.back(),
          "frame " + std::to_string(numbers_.back()) + " has no line for bone " + in_quotes(asf_.bones[i].name) + ".",
          last ? "The file was cut off; export or copy it again." : "Check that this motion belongs to this skeleton, or add the line.");
    }
    return true;
  }

  bool read_bone() {
    const std::string_view name = scanner_.word();
    const int line = scanner_.line();
    if (frame_lines_.empty())
      return stop(ErrorCode::syntax, line, in_quotes(name) + " stands before the first frame number.",
                  "Check that it is an AMC file; a frame begins with its number.");
    const auto found = index_.find(name);
    if (found == index_.end())
      return stop(ErrorCode::unknown, line, "the skeleton has no bone " + in_quotes(name) + ".",
                  "Read the motion with the ASF file that belongs to it.");
    const std::size_t bone = found->second;
    if (seen_[bone])
      return stop(ErrorCode::duplicate, line,
                  "bone " + in_quotes(name) + " has two lines in frame " + std::to_string(numbers_.back()) + ".", "Remove one of them.");
    seen_[bone] = 1;
    const std::size_t count = asf_.bones[bone].freedoms.size();
    double* values = values_.data() + values_.size() - numbers_a_frame_ + first_[bone];
    std::size_t n = 0;
    for (std::string_view word = scanner_.word_on_line(); !word.empty() && !word.starts_with('#'); word = scanner_.word_on_line(), ++n) {
      const auto value = measured_number(word);
      if (!value) {
        const NumberFault fault = number_fault(word);
        problems_.add(fault.code, line, fault.message, fault.remedy);
      }
      if (n < count) values[n] = value.value_or(0);
    }
    scanner_.rest_of_line();
    if (n != count)
      return stop(ErrorCode::structure, line,
                  "bone " + in_quotes(name) + " has " + std::to_string(n) + " numbers, but " + std::to_string(count) + " freedoms.",
                  "Check that this motion belongs to this skeleton, and that the line is whole.");
    return true;
  }

  void evaluate_frame(const double* value, double angle_unit, Vec3* translation, Quat* rotation) const {
    const std::size_t joints = asf_.skeleton.joints.size();
    const double unit = asf_.skeleton.unit;
    std::vector<double>& stretch = stretch_;
    stretch.assign(joints, 0.0);
    for (std::size_t i = 0; i < joints; ++i) {
      const SkeletonJoint& joint = asf_.skeleton.joints[i];
      const Asf::Bone& bone = asf_.bones[i];
      translation[i] = joint.offset;
      if (joint.parent >= 0) {
        const auto p = static_cast<std::size_t>(joint.parent);
        translation[i] += asf_.bones[p].direction * stretch[p];
      }
      Quat turn;
      Vec3 shift;
      for (const AsfFreedom& f : bone.freedoms) {
        const double x = *value++;
        switch (f.kind) {
          case AsfFreedom::Kind::rotation: turn = axis_angle(axes_.unit(f.axis), x * angle_unit) * turn; break;
          case AsfFreedom::Kind::translation: shift += axes_.unit(f.axis) * (x * unit); break;
          case AsfFreedom::Kind::length: stretch[i] = x * unit; break;
        }
      }
      // The root's position is in the world; a bone's is in its own frame.
      translation[i] += joint.parent < 0 ? shift : rotate(bone.axis, shift);
      rotation[i] = normalized(bone.axis * turn * bone.axis.conjugate());
    }
  }

  static void interpolate(MeasuredMotion& motion, std::size_t frame, std::size_t before, std::size_t after) {
    const std::size_t joints = motion.skeleton.joints.size();
    const double s = static_cast<double>(frame - before) / static_cast<double>(after - before);
    for (std::size_t i = 0; i < joints; ++i) {
      const Vec3 a = motion.translations[before * joints + i], b = motion.translations[after * joints + i];
      motion.translations[frame * joints + i] = a + (b - a) * s;
      motion.rotations[frame * joints + i] = slerp(motion.rotations[before * joints + i], motion.rotations[after * joints + i], s);
    }
  }

  Scanner scanner_;
  std::uint64_t text_size_;
  const Asf& asf_;
  double rate_;
  Problems& problems_;
  FileAxes axes_;
  bool degrees_;
  std::map<std::string, std::size_t, std::less<>> index_;
  std::vector<std::size_t> first_;  ///< [bones] where a bone's numbers begin in a frame
  std::size_t numbers_a_frame_ = 0;
  std::vector<char> seen_;        ///< [bones] in this frame
  std::vector<long> numbers_;     ///< [frames] as the file counts them
  std::vector<int> frame_lines_;  ///< [frames]
  std::vector<double> values_;    ///< [frames][numbers_a_frame]
  long missing_ = 0;
  mutable std::vector<double> stretch_;  ///< [bones] m, of the frame being evaluated
};

}  // namespace

Result<MeasuredMotion> read_amc(std::string_view text, std::string_view file_name, const Asf& asf, const AmcOptions& options,
                                ReadNotes* notes) {
  Problems problems(file_name);
  const auto plain = plain_text(text, "AMC", problems);
  if (!plain) return fail(problems.take());
  const double rate = options.rate > 0 && std::isfinite(options.rate) ? options.rate : 120;
  AmcReader reader(*plain, asf, rate, problems);
  if (!reader.read()) return fail(problems.take());
  MeasuredMotion motion;
  motion.name = stem_of(file_name);
  motion.source = std::string(file_name);
  motion.skeleton = asf.skeleton;
  reader.evaluate(motion);
  if (notes) {
    notes->frame_time = 0;
    notes->metres_per_unit = asf.skeleton.unit;
    notes->remarks.push_back("The format does not tell the frame rate; it is taken as " + to_text(rate) + " frames a second.");
    if (reader.missing_frames() > 0)
      notes->remarks.push_back(std::to_string(reader.missing_frames()) + " missing frames were filled in by interpolation.");
  }
  return motion;
}

}  // namespace ugoki::formats
