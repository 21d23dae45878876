#include "postgres_server.h"

#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <thread>

namespace ugoki::store {
namespace {

namespace fs = std::filesystem;

std::string reason;

/// Folder with the programs of the newest installed PostgreSQL version; empty: none.
std::string find_programs() {
  std::string best;
  std::error_code ignored;
  for (const auto& version : fs::directory_iterator("/usr/lib/postgresql", ignored))
    if (fs::exists(version.path() / "bin/initdb", ignored)) best = std::max(best, (version.path() / "bin").string());
  return best;
}

}  // namespace

PostgresServer* PostgresServer::get() {
  static const std::unique_ptr<PostgresServer> server = [] {
    std::unique_ptr<PostgresServer> made(new PostgresServer);
    if (!made->create()) made.reset();
    return made;
  }();
  return server.get();
}

const std::string& PostgresServer::unavailable_reason() { return reason; }

bool PostgresServer::create() {
  programs_ = find_programs();
  if (programs_.empty()) {
    reason = "PostgreSQL is not installed (apt-get install postgresql).";
    return false;
  }
  std::string name = (fs::temp_directory_path() / "ugoki-pg-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) {
    reason = "no temporary folder";
    return false;
  }
  folder_ = name;
  if (::geteuid() == 0) {  // the server refuses to run as root
    const passwd* user = ::getpwnam("postgres");
    if (user == nullptr) user = ::getpwnam("nobody");
    if (user == nullptr || ::chown(folder_.c_str(), user->pw_uid, user->pw_gid) != 0) {
      reason = "PostgreSQL does not run as root, and there is no other user";
      return false;
    }
    as_user_ = "setpriv --reuid=" + std::to_string(user->pw_uid) + " --regid=" + std::to_string(user->pw_gid) + " --clear-groups -- ";
    ::chmod(folder_.c_str(), 0755);
  }
  if (run(programs_ + "/initdb -D " + folder_ + "/data -A trust -U ugoki -E UTF8 --locale=C.UTF-8 --no-sync") != 0 || !start()) {
    reason = "PostgreSQL could not be started; see " + folder_;
    return false;
  }
  return true;
}

int PostgresServer::run(const std::string& command) const {
  return std::system(("cd " + folder_ + " && " + as_user_ + command + " >> " + folder_ + "/log 2>&1 < /dev/null").c_str());
}

bool PostgresServer::start() {
  for (int attempt = 0; attempt < 100; ++attempt) {
    if (run(programs_ + "/pg_ctl -D " + folder_ + "/data -l " + folder_ + "/server.log -w -t 60 -o \"-k " + folder_ +
            " -c listen_addresses=''\" start") == 0)
      return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));  // processes of a killed server may still be running
  }
  return false;
}

void PostgresServer::stop() { run(programs_ + "/pg_ctl -D " + folder_ + "/data -m immediate -w stop"); }

PostgresServer::~PostgresServer() {
  if (folder_.empty()) return;
  stop();
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

pid_t PostgresServer::pid() const {
  std::ifstream file(folder_ + "/data/postmaster.pid");
  pid_t pid = 0;
  file >> pid;
  return pid;
}

void PostgresServer::signal_all(int signal) const {
  const pid_t postmaster = pid();
  if (postmaster <= 1) return;
  if (signal == SIGSTOP) ::kill(postmaster, signal);  // the postmaster first, so that it starts no further process
  const std::string main_thread = "/proc/" + std::to_string(postmaster) + "/task/" + std::to_string(postmaster) + "/children";
  std::ifstream children(main_thread);
  for (pid_t child = 0; children >> child;) ::kill(child, signal);
  if (signal != SIGSTOP) ::kill(postmaster, signal);
}

std::string PostgresServer::library() const { return "postgresql://ugoki@/postgres?host=" + folder_; }

std::string PostgresServer::fresh_library() {
  if (psql("DELETE FROM ugoki.entry; DELETE FROM ugoki.blob") != "") (void)psql("DROP SCHEMA IF EXISTS ugoki CASCADE");
  return library();
}

std::string PostgresServer::psql(const std::string& sql) const {
  const std::string command = programs_ + "/psql -q -A -t -h " + folder_ + " -U ugoki -d postgres -c \"" + sql + "\" 2>&1";
  std::string out;
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return out;
  char buffer[4096];
  while (const std::size_t n = std::fread(buffer, 1, sizeof buffer, pipe)) out.append(buffer, n);
  ::pclose(pipe);
  while (!out.empty() && out.back() == '\n') out.pop_back();
  return out;
}

}  // namespace ugoki::store
