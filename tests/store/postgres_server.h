#pragma once
// A PostgreSQL server for the tests, in a temporary folder. Clients connect through a socket in that folder. The server and its folder are
// removed when the test program ends.

#include <sys/types.h>

#include <csignal>
#include <string>

namespace ugoki::store {

class PostgresServer {
 public:
  /// The server, created and started by the first call. Null if PostgreSQL is not installed or cannot be started.
  static PostgresServer* get();
  /// Why get() returned null, for skipped tests.
  static const std::string& unavailable_reason();

  /// Empties the database. @return its address, "postgresql://ugoki@/postgres?host=..."
  std::string fresh_library();
  /// The address of the database.
  [[nodiscard]] std::string library() const;

  /// Process id of the postmaster.
  [[nodiscard]] pid_t pid() const;
  void stop();
  /// Stops all processes of the server with SIGSTOP: connections stay open, but nothing answers.
  void freeze() const { signal_all(SIGSTOP); }
  /// Continues all processes of the server with SIGCONT.
  void thaw() const { signal_all(SIGCONT); }
  /// Starts the server, also after stop() or after it was killed. @return true if it accepts connections
  bool start();
  /// Runs SQL with psql as the owner of the server. @return the output of psql
  std::string psql(const std::string& sql) const;

  ~PostgresServer();

 private:
  PostgresServer() = default;
  bool create();
  void signal_all(int signal) const;
  int run(const std::string& command) const;
  std::string folder_, programs_, as_user_;
};

}  // namespace ugoki::store
