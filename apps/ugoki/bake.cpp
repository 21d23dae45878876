// `ugoki bake`: runs many variations of content on all cores and keeps the results in a table.

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <memory>
#include <thread>

#include "output.h"
#include "output_files.h"
#include "simulate.h"
#include "sources.h"
#include "sweep_table.h"
#include "ugoki/base/hash.h"
#include "ugoki/base/number.h"
#include "ugoki/content/generate.h"
#include "ugoki/files/files.h"
#include "ugoki/sweep/plot.h"
#include "verb.h"

namespace ugoki::cli {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct Options {
  std::vector<std::string> targets, vary;
  std::string table, name, csv, part, slurm_partition, slurm_time = "01:00:00";
  SourceOptions source;
  std::uint64_t random = 0, seed = 1;
  double duration = 0, time_limit = 600;
  int jobs = 0, slurm = 0;
  bool json = false, dry_run = false;
};

std::uint64_t hash_of(std::span<const std::byte> bytes) {
  Hash64 hash;
  hash.add_bytes(bytes.data(), bytes.size());
  return hash.value();
}

std::string hex(std::uint64_t x) {
  std::string out(16, '0');
  for (std::size_t i = 0; i < 16; ++i) out[i] = "0123456789abcdef"[(x >> (60 - 4 * i)) & 15];
  return out;
}

Json refused_row(const Error& error) { return {{"status", "failed"}, {"message", error.text()}}; }

/// Runs one variation and returns its row. Called in a child process.
Json run_one(const SceneSource& source, const SweepPlan& plan, const std::vector<std::string>& values) {
  content::Scenario scenario = source.scenario;
  if (Result<void> done = apply_variations(scenario, source.resources, plan.variations, values); !done) return refused_row(done.error());
  const Result<std::vector<std::byte>> ugx = content::generate(scenario, source.resources);
  if (!ugx) return refused_row(ugx.error());
  Result<HostedPlayer> hosted = open_hosted(*ugx, source.name);
  if (!hosted) return refused_row(hosted.error());
  content::Player& player = hosted->player;
  const double duration = plan.duration > 0 ? plan.duration : player.content().duration;
  const auto steps = static_cast<std::uint64_t>(std::llround(duration / player.step_size()));
  Json row = {{"status", "done"}};
  const std::clock_t began = std::clock();
  for (std::uint64_t i = 0; i < steps; ++i)
    if (const Result<void> good = player.step(); !good) {
      row = {{"status", "stopped"}, {"message", good.error().text()}};
      break;
    }
  row["processor_s"] = static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC;
  row["steps"] = player.step_count();
  row["state_hash"] = hex(player.state_hash());
  RunReport report;
  for (std::size_t i = 0; i < player.content().characters.size(); ++i) {
    const content::ExecutableCharacter& c = player.content().characters[i];
    report.characters.push_back({c.id,
                                 c.name,
                                 0,
                                 c.control.mode != content::ControlMode::passive && !c.track.empty(),
                                 player.measures(static_cast<int>(i)),
                                 {},
                                 {}});
  }
  const content::PlayerMeasures m = report.worst();
  row["tracking_rms_deg"] = m.tracking_rms_deg;
  row["assist_rms_bw"] = m.assist_rms_bw;
  row["assist_force_rms_bw"] = m.assist_force_rms_bw;
  row["assist_max_bw"] = m.assist_max_bw;
  row["foot_skate_cm"] = m.foot_skate_cm;
  row["foot_skate_worst_cm"] = m.foot_skate_worst_cm;
  row["penetration_mm"] = m.penetration_mm;
  row["penetration_rms_mm"] = m.penetration_rms_mm;
  row["fell"] = m.fell;
  if (m.release_time >= 0) row["release_time"] = m.release_time;
  return row;
}

/// A child process that computes one run and writes its row into a pipe.
struct Worker {
  std::uint64_t number = 0;
  pid_t pid = -1;
  int pipe = -1;
  std::string text;
  Clock::time_point began;
};

Result<Worker> start_worker(std::uint64_t number, const SceneSource& source, const SweepPlan& plan,
                            const std::vector<std::string>& values) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return fail(ErrorCode::io, "bake", "No pipe can be created.", "Use fewer --jobs.");
  const pid_t pid = ::fork();
  if (pid < 0) {
    ::close(ends[0]);
    ::close(ends[1]);
    return fail(ErrorCode::io, "bake", std::string("No process can be started: ") + std::strerror(errno) + ".", "Use fewer --jobs.");
  }
  if (pid == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // if the parent ends, nobody stores the result of this run
    ::setpgid(0, 0);                     // Ctrl+C reaches only the parent
    ::close(ends[0]);
    const std::string row = json::to_text(run_one(source, plan, values));
    std::string_view rest = row;
    while (!rest.empty()) {
      const ssize_t n = ::write(ends[1], rest.data(), rest.size());
      if (n <= 0 && errno != EINTR) ::_exit(1);
      if (n > 0) rest.remove_prefix(static_cast<std::size_t>(n));
    }
    ::_exit(0);  // without destructors: the table and other descriptors belong to the parent
  }
  ::close(ends[1]);
  return Worker{number, pid, ends[0], "", Clock::now()};
}

/// Waits for the child and returns its row. If the child crashed or timed out, the row reports this.
Json finish(Worker& w, bool timed_out, double limit) {
  if (timed_out) ::kill(w.pid, SIGKILL);
  int status = 0;
  while (::waitpid(w.pid, &status, 0) < 0 && errno == EINTR) {
  }
  ::close(w.pipe);
  if (timed_out) return {{"status", "timeout"}, {"message", "The run took more than " + std::to_string(static_cast<long>(limit)) + " s."}};
  Result<Json> row = json::parse_json(w.text, "run");
  if (row && row->is_object()) return std::move(*row);
  if (WIFSIGNALED(status))
    return {{"status", "crashed"}, {"message", std::string("The process was ended by signal ") + ::strsignal(WTERMSIG(status)) + "."}};
  return {{"status", "crashed"}, {"message", "The process ended without a result."}};
}

/// The runs that this call computes: part I of N has the run numbers I, I + N, I + 2 N ...
struct Part {
  std::uint64_t index = 0, count = 1;
};
Result<Part> read_part(const std::string& text) {
  if (text.empty()) return Part{};
  const std::size_t slash = text.find('/');
  const std::optional<long> index = parse_long(text.substr(0, slash)),
                            count = slash == std::string::npos ? std::nullopt : parse_long(text.substr(slash + 1));
  if (!index || !count || *count < 1 || *index < 0 || *index >= *count)
    return fail(ErrorCode::syntax, "--part " + text, "A part has the form I/N with 0 <= I < N.", "Write, for example, --part 0/8.");
  return Part{static_cast<std::uint64_t>(*index), static_cast<std::uint64_t>(*count)};
}

std::string shell_quoted(const std::string& word) {
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// Writes the job scripts of --slurm, unless they would overwrite other files, and submits them with sbatch: an array with one task for
/// each part, then the merge.
int submit(const Options& o, const std::vector<NamedFile>& inputs, std::vector<NamedFile> outputs) {
  std::error_code ec;
  const std::string program = fs::read_symlink("/proc/self/exe", ec).string();
  const bool server = store::is_postgres(o.table);
  const std::string stem = server ? fs::absolute("bake-" + o.name).string() : fs::absolute(o.table).replace_extension().string();
  std::string words = shell_quoted(program) + " bake";
  for (const std::string& t : o.targets) words += ' ' + shell_quoted(fs::exists(t, ec) ? fs::absolute(t).string() : t);
  for (const std::string& v : o.vary) words += " --vary " + shell_quoted(v);
  if (o.random > 0) words += " --random " + std::to_string(o.random) + " --seed " + std::to_string(o.seed);
  if (o.duration > 0) words += " --duration " + to_text(o.duration);
  words += " --time-limit " + to_text(o.time_limit);
  const std::string common =
      "#!/bin/bash\n#SBATCH --requeue\n" + (o.slurm_partition.empty() ? "" : "#SBATCH --partition=" + o.slurm_partition + "\n");
  const std::string parts = std::to_string(o.slurm);
  std::string array = common + "#SBATCH --job-name=ugoki-bake\n#SBATCH --array=0-" + std::to_string(o.slurm - 1) +
                      "\n#SBATCH --time=" + o.slurm_time + "\n#SBATCH --output=" + stem +
                      ".%a.log\n#SBATCH --open-mode=append\n# A task that is requeued continues its part.\nexec " + words +
                      " --part \"$SLURM_ARRAY_TASK_ID/" + parts + "\" --jobs \"${SLURM_CPUS_PER_TASK:-1}\" --table ";
  std::string merge = common + "#SBATCH --job-name=ugoki-merge\n#SBATCH --output=" + stem + ".merge.log\nexec " + words + " --table ";
  if (server) {  // all tasks write into the table of the server; the last job only computes missing runs
    const std::string table = shell_quoted(o.table) + " --name " + o.name;
    array += table + '\n';
    merge += table + '\n';
  } else {
    array += shell_quoted(stem) + ".part\"$SLURM_ARRAY_TASK_ID\".db\n";
    merge += shell_quoted(fs::absolute(o.table).string()) + " --jobs 1";
    for (int i = 0; i < o.slurm; ++i) merge += " --merge " + shell_quoted(stem + ".part" + std::to_string(i) + ".db");
    merge += '\n';
  }
  for (const std::string& name : {stem + ".slurm", stem + ".merge.slurm"}) {
    outputs.push_back({"a script of --slurm", name});
    if (Result<void> may = check_outputs(inputs, outputs); !may) return print_error(may.error(), o.json);
    if (Result<void> may = check_derived(name, "#SBATCH --job-name=ugoki-"); !may) return print_error(may.error(), o.json);
  }
  for (const auto& [name, text] : {std::pair{stem + ".slurm", array}, {stem + ".merge.slurm", merge}})
    if (Result<void> done = files::write_file(name, text); !done) return print_error(done.error(), o.json);
  const std::string command = "id=$(sbatch --parsable " + shell_quoted(stem + ".slurm") +
                              ") && sbatch --parsable --dependency=afterany:$id " + shell_quoted(stem + ".merge.slurm");
  if (o.dry_run) {
    print_line("Wrote " + stem + ".slurm and " + stem + ".merge.slurm. Submit them with:");
    print_line("  " + command);
    return 0;
  }
  const int status = std::system(command.c_str());
  if (status != 0)
    return print_error(Error(ErrorCode::io, "sbatch", "The jobs could not be submitted.",
                             "Check Slurm with `sinfo`, or use --dry-run and submit the written scripts yourself."),
                       o.json);
  return 0;
}

int run_bake(const Options& o, const std::vector<std::string>& merges) {
  SweepPlan plan;
  plan.random = o.random;
  plan.seed = o.seed;
  plan.duration = o.duration;
  for (const std::string& text : o.vary) {
    Result<Variation> v = read_variation(text, o.random > 0);
    if (!v) return print_error(v.error(), o.json);
    for (const Variation& other : plan.variations)
      if (other.name == v->name)
        return print_error(
            Error(ErrorCode::duplicate, "--vary " + text, "'" + v->name + "' is varied twice.", "Give all its values in one --vary."),
            o.json);
    plan.variations.push_back(std::move(*v));
  }
  if (Result<void> good = sweep::check_address({o.table, o.name}); !good) return print_error(good.error(), o.json);
  const Result<Part> part = read_part(o.part);
  if (!part) return print_error(part.error(), o.json);
  std::vector<NamedFile> inputs = input_files(o.targets, o.source);
  for (const std::string& path : merges) {
    std::error_code missing;
    if (const fs::file_status status = fs::status(path, missing); fs::exists(status) && !fs::is_regular_file(status))
      return print_error(Error(ErrorCode::io, path, "This is not a file.", "Name the table of a part, an SQLite file."), o.json);
    inputs.push_back({"--merge", path});
  }
  const std::string table_file = store::is_postgres(o.table) ? "" : o.table;
  const std::vector<NamedFile> outputs = {{"--table", table_file}, {"--csv", o.csv}};
  if (Result<void> may = check_outputs(inputs, outputs); !may) return print_error(may.error(), o.json);
  if (o.slurm > 0) return submit(o, inputs, outputs);
  std::vector<SceneSource> sources;
  for (const std::string& target : o.targets) {
    Result<SceneSource> source = load_scene(target, o.source, 0.002);
    if (!source) return print_error(source.error(), o.json);
    const Result<std::vector<std::byte>> ugx = content::generate(source->scenario, source->resources);
    if (!ugx) return print_error(ugx.error(), o.json);
    plan.targets.push_back(target);
    plan.hashes.push_back(hash_of(*ugx));
    sources.push_back(std::move(*source));
  }
  constexpr std::uint64_t max_runs = 100'000'000;
  const std::uint64_t total = plan.size();
  if (total > max_runs)
    return print_error(Error(ErrorCode::range, "--vary", "The sweep has more than " + std::to_string(max_runs) + " runs.",
                             "Give fewer values, or --random."),
                       o.json);
  {  // find errors in names and values before thousands of runs fail with the same error
    content::Scenario first = sources[0].scenario;
    if (Result<void> good = apply_variations(first, sources[0].resources, plan.variations, plan.run(part->index).second); !good)
      return print_error(good.error(), o.json);
    for (const SceneSource& source : sources)
      if (Result<void> good = check_push_links(source.scenario, source.resources, plan.variations); !good)
        return print_error(good.error(), o.json);
  }
  if (o.dry_run) {
    print_line(std::to_string(total) + " runs");
    for (std::uint64_t n = 0; n < std::min<std::uint64_t>(total, 10); ++n) {
      const auto [target, values] = plan.run(n);
      std::string line = "  " + plan.targets[target];
      for (std::size_t i = 0; i < values.size(); ++i) line += "  " + plan.variations[i].name + "=" + values[i];
      print_line(line);
    }
    return 0;
  }
  Result<SweepTable> table = SweepTable::open({o.table, o.name}, plan);
  if (!table) return print_error(table.error(), o.json);
  for (const std::string& path : merges) {
    const Result<std::int64_t> added = table->merge(path);
    if (!added) return print_error(added.error(), o.json);
  }
  const Result<std::vector<std::uint64_t>> finished = table->finished();
  if (!finished) return print_error(finished.error(), o.json);
  std::vector<std::uint64_t> open;
  for (std::uint64_t n = part->index; n < total; n += part->count)
    if (!std::ranges::binary_search(*finished, n)) open.push_back(n);
  const std::uint64_t mine = (total - part->index + part->count - 1) / part->count;

  catch_interrupt();
  const int jobs = o.jobs > 0 ? o.jobs : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  Progress progress("bake");
  std::vector<Worker> running;
  std::size_t next = 0;
  std::uint64_t added = 0;
  std::optional<Error> failure;
  while ((next < open.size() && !interrupted() && !failure) || !running.empty()) {
    while (running.size() < static_cast<std::size_t>(jobs) && next < open.size() && !interrupted() && !failure) {
      const auto [target, values] = plan.run(open[next]);
      Result<Worker> worker = start_worker(open[next], sources[target], plan, values);
      if (!worker) {
        failure = worker.error();
        break;
      }
      running.push_back(std::move(*worker));
      ++next;
    }
    if (interrupted() || failure) {  // running runs are lost; the next call repeats them
      for (Worker& w : running) {
        ::kill(w.pid, SIGKILL);
        while (::waitpid(w.pid, nullptr, 0) < 0 && errno == EINTR) {
        }
        ::close(w.pipe);
      }
      break;
    }
    std::vector<pollfd> waits;
    for (const Worker& w : running) waits.push_back({w.pipe, POLLIN, 0});
    ::poll(waits.data(), waits.size(), 200);
    for (std::size_t i = running.size(); i-- > 0;) {
      Worker& w = running[i];
      const bool timed_out = std::chrono::duration<double>(Clock::now() - w.began).count() > o.time_limit;
      bool ended = timed_out;
      if (!ended && (waits[i].revents & (POLLIN | POLLHUP | POLLERR)) != 0) {
        char bytes[65536];
        const ssize_t n = ::read(w.pipe, bytes, sizeof bytes);
        if (n > 0) w.text.append(bytes, static_cast<std::size_t>(n));
        ended = n == 0;
      }
      if (!ended) continue;
      const Json row = finish(w, timed_out, o.time_limit);
      const auto [target, values] = plan.run(w.number);
      if (Result<void> done = table->add(w.number, plan.targets[target], values, row); !done) failure = done.error();
      ++added;
      running.erase(running.begin() + static_cast<std::ptrdiff_t>(i));
      progress.show(static_cast<double>(mine - open.size() + added) / static_cast<double>(mine));
    }
  }
  progress.clear();
  if (failure) return print_error(*failure, o.json);
  if (interrupted()) {
    print_line(std::to_string(mine - open.size() + added) + " of " + std::to_string(mine) + " runs are in " +
               store::without_password(o.table) + ". The same command continues.");
    return print_error(interrupted_error(), o.json);
  }
  if (!o.csv.empty()) {
    const Result<std::string> text = table->csv();
    if (!text) return print_error(text.error(), o.json);
    if (Result<void> done = files::write_file(o.csv, *text); !done) return print_error(done.error(), o.json);
  }
  const Result<SweepFailures> failures = table->failures(part->index, part->count);
  if (!failures) return print_error(failures.error(), o.json);
  if (o.json)
    print_json({{"table", store::without_password(o.table)}, {"runs", mine}, {"added", added}, {"not_done", failures->count}});
  else
    print_line(std::to_string(mine) + " runs in " + store::without_password(o.table) + ", of which " + std::to_string(added) + " now" +
               (failures->count > 0 ? ", " + std::to_string(failures->count) + " without result (column status)" : "") + ".");
  if (mine == 0 || failures->count < mine) return 0;
  print_message("No run has a result. The first: " + failures->first);
  return 1;
}

struct PlotOptions {
  std::string table, name, x, y, by, out, title;
  bool json = false;
};

int run_plot(const PlotOptions& o) {
  if (Result<void> may = check_outputs({{"the table", o.table}}, {{"--out", o.out}}); !may) return print_error(may.error(), o.json);
  const Result<sweep::TablePlot> plot = sweep::plot_table({o.table, o.name}, {o.title, o.x, o.y, o.by});
  if (!plot) return print_error(plot.error(), o.json);
  if (Result<void> done = files::write_file(o.out, plot->svg); !done) return print_error(done.error(), o.json);
  if (o.json)
    print_json({{"file", o.out}, {"points", plot->points}});
  else
    print_line("Wrote " + o.out + " with " + std::to_string(plot->points) + " runs.");
  return 0;
}

void add_plot_verb(Verb bake, Action& action) {
  auto o = std::make_shared<PlotOptions>();
  Verb verb = bake.add_subcommand("plot", "Draw a measure of a sweep over one of its parameters, as SVG.");
  verb.add_option("table", o->table, "Table of the sweep: an SQLite file or postgresql://user@host/database").required();
  verb.add_option("--name", o->name, "Name of the sweep in a PostgreSQL database");
  verb.add_option("--x", o->x, "Column of the horizontal axis, for example push").required();
  verb.add_option("--y", o->y, "Column of the vertical axis, for example fell").required();
  verb.add_option("--by", o->by, "Column whose values become series, each with its own colour");
  verb.add_option("--out", o->out, "File to write").required().type_name("FILE");
  verb.add_option("--title", o->title, "Title (default: names of the columns)");
  verb.add_flag("--json", o->json, "Print one JSON object");
  verb.footer("Example:\n  ugoki bake plot push.db --x push --y fell --by push-angle --out push.svg");
  verb.callback([o, &action] { action = [o] { return run_plot(*o); }; });
}

}  // namespace

void add_bake_verb(Verb app, Action& action) {
  auto o = std::make_shared<Options>();
  auto merges = std::make_shared<std::vector<std::string>>();
  Verb verb = app.add_subcommand("bake", "Run many variations of content on all cores and keep the results in a table.");
  verb.add_option("targets", o->targets, "Projects, motion files or motions of the library");
  verb.add_option("--table", o->table,
                  "Table of the results: an SQLite file, or postgresql://user@host/database; an existing table is continued")
      .type_name("FILE");
  verb.add_option("--name", o->name, "Name of the sweep in a PostgreSQL database");
  add_plot_verb(verb, action);
  verb.add_option("--vary", o->vary,
                  "NAME=VALUE,VALUE or NAME=LOW:HIGH:COUNT; may be repeated. Names: push (N), push-angle (degrees), push-time, "
                  "push-duration, push-link, assist-limit, tracking, "
                  "balance, friction, restitution, gravity, steps-per-s, a JSON pointer into the scenario, lsi:ID.PARAMETER (in a nested circuit lsi:CIRCUIT/ID.PARAMETER)")
      .type_name("SPEC");
  verb.add_option("--random", o->random, "Draw this many runs for each target at random; ranges are NAME=LOW:HIGH")
      .check(range(1, 100'000'000));
  verb.add_option("--seed", o->seed, "Seed of --random").capture_default_str();
  verb.add_option("--duration", o->duration, "Seconds to run (default: to the end)").check(range(0.0005, 86400.0));
  verb.add_option("--jobs", o->jobs, "Runs at the same time (default: number of cores)").check(range(1, 1024));
  verb.add_option("--time-limit", o->time_limit, "Seconds after which a run is ended and recorded as timeout")
      .check(range(0.1, 1e6))
      .capture_default_str();
  verb.add_option("--csv", o->csv, "Write the complete table as CSV at the end").type_name("FILE");
  verb.add_option("--part", o->part, "Compute only part I of N: I/N");
  verb.add_option("--merge", *merges, "Take the rows of the table of another part; may be repeated").type_name("FILE");
  verb.add_option("--slurm", o->slurm, "Write job scripts for this many parts and submit them with sbatch").check(range(1, 10'000));
  verb.add_option("--slurm-partition", o->slurm_partition, "Partition of Slurm");
  verb.add_option("--slurm-time", o->slurm_time, "Time limit of a Slurm task").capture_default_str();
  verb.add_flag("--dry-run", o->dry_run, "Print the runs, or write the scripts of --slurm, but start nothing");
  add_library_option(verb, o->source.library);
  verb.add_flag("--json", o->json, "Print one JSON object");
  verb.footer("Example:\n  ugoki bake walk.bvh --vary push=0:600:13 --vary push-angle=0,90,180,270 --table push.db --csv push.csv");
  verb.callback([o, merges, verb, &action] {
    if (verb.has_parsed_verb()) return;
    if (o->targets.empty()) refuse("bake", "Name at least one target, or `plot`.");
    if (o->table.empty()) refuse("bake", "Name the table of the results, for example --table push.db.");
    action = [o, merges] { return run_bake(*o, *merges); };
  });
}

}  // namespace ugoki::cli
