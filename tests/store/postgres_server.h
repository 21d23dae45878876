#pragma once
// A PostgreSQL server of the tests' own: in a temporary folder, reached through a socket in it, gone when the program ends.

#include <sys/types.h>

#include <string>

namespace ugoki::store {

class PostgresServer {
 public:
  /// Made and started when first asked for. Null where PostgreSQL is not installed; why() says so.
  static PostgresServer* get();
  static const std::string& why();

  /// "postgresql:///library?host=...": the database is made anew, empty.
  std::string fresh_library();
  /// The address of the database as it is.
  [[nodiscard]] std::string library() const;

  /// The postmaster.
  [[nodiscard]] pid_t pid() const;
  void stop();
  /// Starts it again after stop() or after it was killed. @return whether it answers
  bool start();
  /// Runs SQL as the owner of the server with psql. @return what it printed
  std::string psql(const std::string& sql) const;

  ~PostgresServer();

 private:
  PostgresServer() = default;
  bool make();
  int run(const std::string& command) const;
  std::string folder_, programs_, as_user_;
};

}  // namespace ugoki::store
