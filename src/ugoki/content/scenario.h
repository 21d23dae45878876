#pragma once
// The scenario document: the characters of a piece of content with their tracks, the events, and the settings.
// docs/scenario.md describes its JSON form and its meaning.

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/content/film.h"
#include "ugoki/content/gait_recipe.h"
#include "ugoki/content/look.h"
#include "ugoki/content/prop.h"
#include "ugoki/content/rules.h"
#include "ugoki/content/variables.h"
#include "ugoki/mechanism/joint.h"
#include "ugoki/motion_edit/keyed_layer.h"
#include "ugoki/spatial/vec3.h"

namespace ugoki::content {

/// Highest version of documents that this program reads. Documents without nested scenarios are written as version 1.
inline constexpr int scenario_version = 2;

/// Keys that a user set over the motion of a clip. The ids of the layers of one clip are different; two clips can have layers of the same
/// id.
struct ScenarioLayer {
  std::string id, name;
  bool on = true;  ///< false: the layer has no effect
  motion_edit::KeyedLayer keyed;
  friend bool operator==(const ScenarioLayer&, const ScenarioLayer&) = default;
};

/// A clip of a character's track, as stored in the document.
struct ScenarioClip {
  std::string id;
  std::string motion;                      ///< id of a motion
  double start = 0;                        ///< s, start on the track
  double length = 0;                       ///< s, length on the track, above 0
  double offset = 0;                       ///< s, time in the motion at the clip's start
  double speed = 1;                        ///< s of motion per s of track
  double blend = 0.3;                      ///< s, duration of the cross-fade from the previous clip
  bool loop = false;                       ///< repeat a cyclic motion
  std::vector<ScenarioLayer> layers = {};  ///< applied to the motion, the first one first
  std::optional<GaitRecipe> gait = {};     ///< settings from which the motion was made; nothing: a motion of the library
  friend bool operator==(const ScenarioClip&, const ScenarioClip&) = default;
};

/// How a character is driven.
///   track    motion control follows the track within the laws of balance
///   passive  no drives
///   path     motion control with high gains and as much root assist as needed keeps the character on its track
///   torque   the torques of the track's torque-oriented motion, from its first state
enum class ControlMode { track, passive, path, torque };
[[nodiscard]] std::string_view name_of(ControlMode mode);

struct ScenarioControl {
  ControlMode mode = ControlMode::track;
  double tracking = 1;        ///< factor on the tracking gains, 0 ... 2
  double balance = 1;         ///< factor on the balance gains, 0 ... 2
  double assist_limit = 0.5;  ///< cap of the root assist, body weights
  double swing = 0;           ///< deg: amplitude to which the character swings while it hangs by grips, 0 ... 90; without root assist only
  friend bool operator==(const ScenarioControl&, const ScenarioControl&) = default;
};

/// Joints of a character that no drive moves: the joint of `link` and all joints below it swing on springs (dynamics/spring_chains.h).
struct ScenarioSecondary {
  std::string link;       ///< name or label of the first link of the chain
  double frequency = 2;   ///< Hz: lowest natural frequency of the chain
  double damping = 0.15;  ///< damping ratio of the lowest mode
  bool neutral = false;   ///< true: the springs rest in the neutral position; false: in the character's pose at time 0
  friend bool operator==(const ScenarioSecondary&, const ScenarioSecondary&) = default;
};

/// Position and heading of a character at the start.
struct ScenarioPlace {
  double x = 0, y = 0, z = 0;  ///< m, world
  double heading = 0;          ///< deg, about Z
  friend bool operator==(const ScenarioPlace&, const ScenarioPlace&) = default;
};

struct ScenarioCharacter {
  std::string id, name;
  std::string mechanism;          ///< id of a mechanism; that of a prop follows from `prop` (prop_mechanism_id())
  std::optional<Prop> prop = {};  ///< the character is a prop: passive, without a track
  std::string color = "#e6e6ea";  ///< "#rrggbb"
  ScenarioMaterial material;
  ScenarioPlace place;
  ScenarioControl control;
  bool muted = false;               ///< left out of playing, with its events
  bool solo = false;                ///< if any character is solo, characters that are not solo are left out
  bool locked = false;              ///< commands that change its clips or remove it are refused
  std::string group;                ///< name of the group of tracks to which it belongs in the timeline; empty: none
  std::vector<ScenarioClip> track;  ///< sorted by start
  std::vector<ScenarioSecondary> secondary = {};
  friend bool operator==(const ScenarioCharacter&, const ScenarioCharacter&) = default;
};

enum class EventType { push, throw_, grab, release, pull };
[[nodiscard]] std::string_view name_of(EventType type);

/// What a link grips, and how.
struct ScenarioGrip {
  Vec3 point;              ///< m: gripping point in the frame of the gripping link
  std::string other;       ///< id of the character that is gripped; empty: the world
  std::string other_link;  ///< name or label of its link
  bool has_at = false;     ///< `at` is given; otherwise the link grips where it is
  Vec3 at;                 ///< m: gripped point in the frame of the other link, or in the world
  bool rigid = false;      ///< the orientation of the link relative to the other one is held as well
  double limit = 450;      ///< N: a larger force opens the grip; 400 to 500 N is the strength of a human hand
  double reach = 0.15;     ///< m: maximum distance of the two points when the grip is made
  friend bool operator==(const ScenarioGrip&, const ScenarioGrip&) = default;
};

/// Target of a pull from a time on.
struct PullTarget {
  double time = 0;  ///< s since the begin of the pull
  Vec3 at;          ///< m, world
  friend bool operator==(const PullTarget&, const PullTarget&) = default;
};

struct ScenarioEvent {
  std::string id;
  EventType type = EventType::push;
  double time = 0;                    ///< s, time at which the event begins
  std::string character;              ///< id of the character on which it acts
  double duration = 0.2;              ///< s (push, pull)
  std::string link;                   ///< name or label of the link (push, pull, grab, release)
  Vec3 force;                         ///< N (push)
  PushAxes axes = PushAxes::world;    ///< of `force` (push)
  Vec3 from, velocity, spin;          ///< position (m), velocity (m/s) and angular velocity (rad/s) of the thrown root, world (throw)
  ScenarioGrip grip;                  ///< (grab)
  Vec3 point;                         ///< m, pulled point in the frame of the link (pull)
  std::vector<PullTarget> path = {};  ///< by rising time; each target holds until the next one (pull)
  friend bool operator==(const ScenarioEvent&, const ScenarioEvent&) = default;
};

/// A named time, to which the studio snaps and jumps. Markers have no effect on the motion.
struct ScenarioMarker {
  std::string id;
  double time = 0;  ///< s
  std::string name;
  friend bool operator==(const ScenarioMarker&, const ScenarioMarker&) = default;
};

/// Coordinates of one joint in a stored pose.
struct PoseJoint {
  std::string link;       ///< name of the link that the joint moves
  std::vector<double> q;  ///< [nq of the joint]
  friend bool operator==(const PoseJoint&, const PoseJoint&) = default;
};

/// A pose that a user stored under a name. The root is at x = y = 0 with heading 0. Poses have no effect on the motion until they are
/// keyed.
struct ScenarioPose {
  std::string id, name;
  std::string mechanism;  ///< id of the mechanism of the posed character; the project need not contain it any more
  std::vector<PoseJoint> joints;
  friend bool operator==(const ScenarioPose&, const ScenarioPose&) = default;
};

/// The part of the scenario that the studio plays (in and out point). to <= from: no range, everything is played.
struct ScenarioRange {
  double from = 0, to = 0;  ///< s
  [[nodiscard]] bool is_set() const { return to > from; }
  friend bool operator==(const ScenarioRange&, const ScenarioRange&) = default;
};

/// An inner scenario that a scenario places in time and space. flatten() expands it to ordinary characters.
struct ScenarioInstance {
  std::string id, name;
  std::string scenario;  ///< id of an inner scenario of the document
  double start = 0;      ///< s: time in the placing scenario at which the inner scenario begins
  ScenarioPlace place;   ///< of the origin of the inner scenario
  bool muted = false;    ///< its characters are left out of playing
  bool solo = false;     ///< if any track is solo, tracks that are not solo are left out
  friend bool operator==(const ScenarioInstance&, const ScenarioInstance&) = default;
};

struct ScenarioGround {
  double height = 0;       ///< m, world
  double friction = 0.9;   ///< Coulomb friction coefficient
  double restitution = 0;  ///< coefficient of restitution, 0 ... 1
  friend bool operator==(const ScenarioGround&, const ScenarioGround&) = default;
};

/// The view without a shot.
struct ScenarioCamera {
  std::string follow;                      ///< id of the character that the camera follows; empty: none
  double distance = 5;                     ///< m, from the camera to its target
  double azimuth = 0.7, elevation = 0.25;  ///< rad
  friend bool operator==(const ScenarioCamera&, const ScenarioCamera&) = default;
};

/// A scenario document, or an inner scenario of a document. The settings of an inner scenario (frame rate, step, gravity, ground, look),
/// its poses and its circuit are those of the document; its own fields for them have their default values.
struct Scenario {
  std::string id;  ///< of an inner scenario; empty for the document
  std::string name = "untitled";
  double duration = 10;          ///< s
  double frame_rate = 60;        ///< display frames per second
  double step = 0.002;           ///< s, simulation step
  Vec3 gravity = {0, 0, -9.81};  ///< m/s^2, world
  ScenarioGround ground;
  std::vector<ScenarioCharacter> characters;
  std::vector<ScenarioEvent> events;        ///< sorted by time
  std::vector<ScenarioMarker> markers;      ///< sorted by time
  std::vector<Rule> rules;                  ///< by falling priority
  std::vector<ScenarioVariable> variables;  ///< in the order in which they are shown
  std::vector<ScenarioPose> poses;          ///< the pose library, in the order in which it is shown
  std::vector<std::string> track_order;     ///< ids of characters in the order of their tracks in the timeline; others follow
  ScenarioRange range;
  ScenarioCamera camera;
  std::vector<FilmCamera> cameras;
  std::vector<FilmShot> shots;  ///< sorted by start
  ScenarioLook look;
  std::string circuit;                      ///< JSON object of docs/circuit.md; empty: the default circuit
  std::vector<ScenarioInstance> instances;  ///< placed inner scenarios
  /// Ids of characters, rules and variables in the order that flatten() gives them; those of instances as "instance/id". Others follow. The
  /// bits of a simulation depend on this order.
  std::vector<std::string> order;
  std::vector<Scenario> scenarios;  ///< the inner scenarios of a document; empty in an inner scenario
  friend bool operator==(const Scenario&, const Scenario&) = default;

  /// Returns the character with this id, or null.
  [[nodiscard]] const ScenarioCharacter* find_character(std::string_view id) const;
  [[nodiscard]] ScenarioCharacter* find_character(std::string_view id);
  /// Returns the inner scenario with this id, or null.
  [[nodiscard]] const Scenario* find_scenario(std::string_view id) const;
  [[nodiscard]] Scenario* find_scenario(std::string_view id);
};

/// Properties of a mechanism that check_scenario() needs.
struct MechanismFacts {
  std::string name;
  int nq = 0;                              ///< count of position coordinates
  bool free_root = false;                  ///< true: the first joint is floating, so that the mechanism can be placed and thrown
  std::vector<std::string> links, labels;  ///< names of all links; labels of the links that have one
  std::vector<JointType> joints;           ///< joint type of each link
  bool mesh_body = false;                  ///< true: a prop can be made from it (is_mesh_body())
};
/// Properties of a motion that check_scenario() needs.
struct MotionFacts {
  std::string name;
  double duration = 0;  ///< s
  int nq = 0;           ///< count of position coordinates
  bool cyclic = false;
  double torque_step = 0;  ///< s: simulation step of the motion's torques; 0: the motion has no torques
};
/// The mechanisms and motions to which a document can refer.
struct Catalogue {
  std::map<std::string, MechanismFacts, std::less<>> mechanisms;  ///< by id
  std::map<std::string, MotionFacts, std::less<>> motions;        ///< by id
};

/// Reads the JSON form. All problems are reported, each with its JSON path ("characters/0/track/2/speed") after `name`. Absent fields get
/// their default values; unknown fields are errors. Clips and events are sorted (see put_in_order()).
[[nodiscard]] Result<Scenario> read_scenario(std::string_view json, std::string_view name);

/// Returns the canonical JSON form, indented by two blanks: equal documents give equal text.
[[nodiscard]] std::string write_scenario(const Scenario& scenario);

/// Returns the problems of the whole document: values out of range and invalid ids. With `catalogue`, references to mechanisms, motions and
/// links are also checked.
[[nodiscard]] Error check_scenario(const Scenario& scenario, const Catalogue* catalogue = nullptr, std::string_view name = "scenario");

/// True if `text` is a valid id: 1 ... `max_size` letters, digits, '-', '_' or '.'.
[[nodiscard]] bool is_id(std::string_view text, std::size_t max_size = 40);
/// True if `text` is a valid id of an item: is_id(), or several of them joined by '/', as flatten() makes them ("duet.1/human").
[[nodiscard]] bool is_item_id(std::string_view text);
/// Maximum size of a mechanism's or motion's id: "mechanism/ID" must fit into the 31 bytes of a section name of *.ugx.
inline constexpr std::size_t max_resource_id = 21;

/// Returns the part of the document that executable data contains: flattened (flatten()), without characters that are muted or not solo,
/// without their events and rules, and without markers, poses, range, locks and the layout of the timeline. A camera that follows a
/// left-out character follows none.
[[nodiscard]] Scenario played_part(Scenario scenario);

/// Sorts clips by start, and events and markers by time; if these are equal, by id. Events of one time are sorted by the last part of their
/// id first, so that nesting them does not change their order.
void put_in_order(Scenario& scenario);

}  // namespace ugoki::content
