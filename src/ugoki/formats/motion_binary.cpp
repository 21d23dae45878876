#include "ugoki/formats/motion_binary.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>

#include "ugoki/base/hash.h"
#include "ugoki/motion/torques.h"

namespace ugoki::formats {
namespace {

static_assert(std::endian::native == std::endian::little, "values are written as their bytes in memory, which must be little-endian");
static_assert(sizeof(Vec3) == 24 && sizeof(Quat) == 32);

constexpr std::string_view motion_mark = "UGOKIMOT";
constexpr std::string_view measured_mark = "UGOKIMEA";
constexpr std::uint32_t format_version = 1;
constexpr std::uint32_t torque_version = 2;  // of motions with torques
constexpr std::size_t header_size = 32;      // bytes: file signature 8, version 4, reserved 4, payload size 8, checksum 8

/// Appends values after space for a header; finish() fills in the header.
class ByteWriter {
 public:
  ByteWriter() : bytes_(header_size) {}

  void raw(const void* data, std::size_t size) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + size);
    if (size > 0) std::memcpy(bytes_.data() + at, data, size);
  }
  void number(double v) { raw(&v, sizeof v); }
  void count(std::uint64_t v) { raw(&v, sizeof v); }
  void integer(std::int32_t v) { raw(&v, sizeof v); }
  void flag(bool v) {
    const std::uint8_t byte = v ? 1 : 0;
    raw(&byte, 1);
  }
  void text(std::string_view v) {
    count(v.size());
    raw(v.data(), v.size());
  }
  void vector(const Vec3& v) { raw(&v, sizeof v); }

  std::vector<std::byte> finish(std::string_view mark, std::uint32_t version = format_version) {
    Hash64 hash;
    hash.add_bytes(bytes_.data() + header_size, bytes_.size() - header_size);
    const std::uint64_t size = bytes_.size() - header_size, sum = hash.value();
    std::memcpy(bytes_.data(), mark.data(), 8);
    std::memcpy(bytes_.data() + 8, &version, 4);
    std::memcpy(bytes_.data() + 16, &size, 8);
    std::memcpy(bytes_.data() + 24, &sum, 8);
    return std::move(bytes_);
  }

 private:
  std::vector<std::byte> bytes_;
};

/// Reads values in sequence. After the first error good() is false and every read returns zero.
class ByteReader {
 public:
  ByteReader(std::span<const std::byte> bytes, std::string_view name) : bytes_(bytes), name_(name) {}

  /// @param newest highest version of the format that the caller reads
  bool begin(std::string_view mark, std::uint32_t newest = format_version) {
    constexpr const char* again = "Restore it from a backup, or import the motion again.";
    if (bytes_.size() < header_size) return refuse(ErrorCode::truncated, "The data ends within its header.", again);
    if (std::memcmp(bytes_.data(), mark.data(), 8) != 0)
      return refuse(ErrorCode::syntax, "The data is not a motion of the expected kind.", "Check which data was stored under this name.");
    std::uint32_t version = 0;
    std::uint64_t size = 0, sum = 0;
    std::memcpy(&version, bytes_.data() + 8, 4);
    std::memcpy(&size, bytes_.data() + 16, 8);
    std::memcpy(&sum, bytes_.data() + 24, 8);
    version_ = version;
    if (version < format_version || version > newest)
      return refuse(ErrorCode::unsupported, "Version " + std::to_string(version) + " of the motion format is not supported.",
                    "Use a newer version of Ugoki.");
    if (size != bytes_.size() - header_size)
      return refuse(ErrorCode::truncated,
                    "The data has " + std::to_string(bytes_.size() - header_size) + " bytes after the header, but the header specifies " +
                        std::to_string(size) + ".",
                    again);
    Hash64 hash;
    hash.add_bytes(bytes_.data() + header_size, bytes_.size() - header_size);
    if (hash.value() != sum) return refuse(ErrorCode::syntax, "The checksum is wrong: the data is damaged.", again);
    at_ = header_size;
    return true;
  }

  bool refuse(ErrorCode code, std::string message, std::string remedy = "Restore it from a backup, or import the motion again.") {
    if (error_.empty()) error_.add(code, name_ + ": byte " + std::to_string(at_), std::move(message), std::move(remedy));
    return false;
  }
  [[nodiscard]] bool good() const { return error_.empty(); }
  [[nodiscard]] std::uint32_t version() const { return version_; }
  [[nodiscard]] Error take() { return std::move(error_); }

  bool raw(void* out, std::size_t size) {
    if (!good()) return false;
    if (size > bytes_.size() - at_) return refuse(ErrorCode::truncated, "The data ends within a value.");
    if (size > 0) std::memcpy(out, bytes_.data() + at_, size);
    at_ += size;
    return true;
  }
  double number() {
    double v = 0;
    if (raw(&v, sizeof v) && std::isnan(v)) refuse(ErrorCode::range, "A value is not a number (NaN).");
    return v;
  }
  double finite() {
    const double v = number();
    if (!std::isfinite(v)) refuse(ErrorCode::range, "A value is not finite.");
    return v;
  }
  /// Reads a count of entries. It is an error if the remaining bytes cannot contain this count, so that it never causes a large allocation.
  /// @param entry_size minimum size of one entry, bytes
  std::size_t count(std::size_t entry_size) {
    std::uint64_t v = 0;
    if (!raw(&v, sizeof v)) return 0;
    if (v > (bytes_.size() - at_) / entry_size) {
      refuse(ErrorCode::truncated, "A count is larger than the rest of the data.");
      return 0;
    }
    return static_cast<std::size_t>(v);
  }
  int integer() {
    std::int32_t v = 0;
    raw(&v, sizeof v);
    return v;
  }
  bool flag() {
    std::uint8_t v = 0;
    raw(&v, 1);
    if (v > 1) refuse(ErrorCode::range, "A flag is neither 0 nor 1.");
    return v == 1;
  }
  std::string text() {
    std::string v(count(1), '\0');
    raw(v.data(), v.size());
    return v;
  }
  Vec3 vector() {
    Vec3 v;
    v.x = finite();
    v.y = finite();
    v.z = finite();
    return v;
  }
  /// Adds an error if bytes are left over.
  void end() {
    if (good() && at_ != bytes_.size()) refuse(ErrorCode::structure, "There are extra bytes at the end.");
  }

 private:
  std::span<const std::byte> bytes_;
  std::string name_;
  std::size_t at_ = 0;
  std::uint32_t version_ = 0;
  Error error_;
};

bool finite_doubles(const void* data, std::size_t count) {
  const auto* p = static_cast<const double*>(data);
  for (std::size_t i = 0; i < count; ++i)
    if (!std::isfinite(p[i])) return false;
  return true;
}

double read_rate(ByteReader& in) {
  const double rate = in.finite();
  if (in.good() && !(rate > 0)) in.refuse(ErrorCode::range, "The frame rate is not positive.");
  return rate;
}

}  // namespace

std::vector<std::byte> write_motion(const Motion& motion) {
  ByteWriter out;
  out.text(motion.name);
  out.text(motion.source);
  out.text(motion.mechanism);
  out.number(motion.rate);
  out.integer(motion.frames);
  out.integer(motion.nq);
  out.flag(motion.cyclic);
  out.count(motion.contacts.size());
  for (const ContactTrack& c : motion.contacts) {
    out.text(c.link);
    out.count(c.on.size());
    out.raw(c.on.data(), c.on.size());
  }
  out.count(motion.q.size());
  out.raw(motion.q.data(), motion.q.size() * sizeof(double));
  const MotionTorques* const torques = is_computed(motion) ? motion.torques.get() : torques_of(motion);
  if (!torques) return out.finish(motion_mark);
  out.number(torques->step);
  for (const std::vector<double>* list : {&torques->q0, &torques->v0, &torques->tau}) {
    out.count(list->size());
    out.raw(list->data(), list->size() * sizeof(double));
  }
  return out.finish(motion_mark, torque_version);
}

Result<Motion> read_motion(std::span<const std::byte> bytes, std::string_view name) {
  ByteReader in(bytes, name);
  if (!in.begin(motion_mark, torque_version)) return fail(in.take());
  Motion m;
  m.name = in.text();
  m.source = in.text();
  m.mechanism = in.text();
  m.rate = read_rate(in);
  m.frames = in.integer();
  m.nq = in.integer();
  m.cyclic = in.flag();
  const std::size_t tracks = in.count(16);  // minimum size of a track, bytes: 2 counts of 8 bytes; name and labels may be empty
  for (std::size_t i = 0; i < tracks && in.good(); ++i) {
    ContactTrack track;
    track.link = in.text();
    track.on.resize(in.count(1));
    in.raw(track.on.data(), track.on.size());
    m.contacts.push_back(std::move(track));
  }
  m.q.resize(in.count(sizeof(double)));
  in.raw(m.q.data(), m.q.size() * sizeof(double));
  if (in.good() && in.version() == torque_version) {
    auto torques = std::make_shared<MotionTorques>();
    torques->step = in.finite();
    for (std::vector<double>* list : {&torques->q0, &torques->v0, &torques->tau}) {
      list->resize(in.count(sizeof(double)));
      in.raw(list->data(), list->size() * sizeof(double));
      if (in.good() && !finite_doubles(list->data(), list->size()))
        in.refuse(ErrorCode::range, "A torque or a first velocity is not finite.");
    }
    torques->path = path_hash(m);
    m.torques = std::move(torques);
  }
  in.end();
  if (in.good() && (m.frames < 0 || m.nq < 0 || m.q.size() != static_cast<std::uint64_t>(m.frames) * static_cast<std::uint64_t>(m.nq)))
    in.refuse(ErrorCode::structure, "The number of coordinates does not match the number of frames.");
  if (in.good() && !finite_doubles(m.q.data(), m.q.size())) in.refuse(ErrorCode::range, "A coordinate is not finite.");
  if (!in.good()) return fail(in.take());
  return m;
}

std::vector<std::byte> write_measured_motion(const MeasuredMotion& motion) {
  ByteWriter out;
  out.text(motion.name);
  out.text(motion.source);
  out.number(motion.rate);
  out.integer(motion.frames);
  const Skeleton& skeleton = motion.skeleton;
  out.text(skeleton.name);
  out.number(skeleton.unit);
  out.number(skeleton.mass);
  out.count(skeleton.joints.size());
  for (const SkeletonJoint& j : skeleton.joints) {
    out.text(j.name);
    out.integer(j.parent);
    out.vector(j.offset);
    out.flag(j.translates);
    out.text(j.rotation_order);
    out.count(j.end_sites.size());
    for (const Vec3& e : j.end_sites) out.vector(e);
    out.count(j.dofs.size());
    for (const MeasuredDof& f : j.dofs) {
      out.vector(f.axis);
      out.flag(f.limited);
      out.number(f.lower);
      out.number(f.upper);
    }
  }
  out.count(motion.translations.size());
  out.raw(motion.translations.data(), motion.translations.size() * sizeof(Vec3));
  out.raw(motion.rotations.data(), motion.rotations.size() * sizeof(Quat));
  return out.finish(measured_mark);
}

Result<MeasuredMotion> read_measured_motion(std::span<const std::byte> bytes, std::string_view name) {
  ByteReader in(bytes, name);
  if (!in.begin(measured_mark)) return fail(in.take());
  MeasuredMotion m;
  m.name = in.text();
  m.source = in.text();
  m.rate = read_rate(in);
  m.frames = in.integer();
  m.skeleton.name = in.text();
  m.skeleton.unit = in.finite();
  m.skeleton.mass = in.finite();
  const std::size_t joints = in.count(61);  // minimum size of a joint, bytes: 4 counts 32, parent 4, offset 24, flag 1
  for (std::size_t i = 0; i < joints && in.good(); ++i) {
    SkeletonJoint j;
    j.name = in.text();
    j.parent = in.integer();
    if (in.good() && (j.parent < -1 || j.parent >= static_cast<int>(i)))
      in.refuse(ErrorCode::structure, "A joint precedes its parent, or has an invalid parent.");
    j.offset = in.vector();
    j.translates = in.flag();
    j.rotation_order = in.text();
    const std::size_t ends = in.count(sizeof(Vec3));
    for (std::size_t k = 0; k < ends && in.good(); ++k) j.end_sites.push_back(in.vector());
    const std::size_t dofs = in.count(41);  // size of a DOF, bytes: axis 24, flag 1, limits 16
    for (std::size_t k = 0; k < dofs && in.good(); ++k) {
      MeasuredDof f;
      f.axis = in.vector();
      f.limited = in.flag();
      f.lower = in.number();  // infinite if there is no limit on that side
      f.upper = in.number();
      j.dofs.push_back(f);
    }
    m.skeleton.joints.push_back(std::move(j));
  }
  const std::size_t poses = in.count(sizeof(Vec3) + sizeof(Quat));
  if (in.good() && (m.frames < 0 || poses != static_cast<std::uint64_t>(m.frames) * joints))
    in.refuse(ErrorCode::structure, "The number of poses does not match the number of frames and joints.");
  if (in.good()) {
    m.translations.resize(poses);
    m.rotations.resize(poses);
    in.raw(m.translations.data(), poses * sizeof(Vec3));
    in.raw(m.rotations.data(), poses * sizeof(Quat));
  }
  in.end();
  if (in.good() && !(finite_doubles(m.translations.data(), 3 * poses) && finite_doubles(m.rotations.data(), 4 * poses)))
    in.refuse(ErrorCode::range, "A pose is not finite.");
  if (!in.good()) return fail(in.take());
  return m;
}

}  // namespace ugoki::formats
