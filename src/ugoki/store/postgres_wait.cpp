#include "ugoki/store/postgres_wait.h"

#include <poll.h>

#include <cerrno>

namespace ugoki::store {
namespace {

using Clock = std::chrono::steady_clock;

/// Waits until the connection can be read or, if `write` is true, written. @return false if neither was possible for max_silence
bool wait_for_socket(PGconn* handle, bool write) {
  const Clock::time_point end = Clock::now() + max_silence;
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
    if (left.count() <= 0) return false;
    pollfd socket{PQsocket(handle), static_cast<short>(POLLIN | (write ? POLLOUT : 0)), 0};
    if (socket.fd < 0) return true;  // the connection is closed; the next call of libpq reports this
    const int ready = ::poll(&socket, 1, static_cast<int>(left.count()));
    if (ready > 0 || (ready < 0 && errno != EINTR)) return true;
  }
}

/// Waits until the connection can be read or, if `write` is true, written. @return false if the server does not respond, or after `limit`
bool wait_while_alive(PGconn* handle, bool write, std::chrono::seconds limit, const std::function<bool()>& alive) {
  const Clock::time_point end = Clock::now() + limit;
  while (!wait_for_socket(handle, write))
    if (Clock::now() >= end || !alive()) return false;
  return true;
}

}  // namespace

PGresult* wait_for_result(PGconn* handle, std::chrono::seconds limit, const std::function<bool()>& alive) {
  PGresult* kept = nullptr;
  for (;;) {
    int unsent = PQflush(handle);
    while (unsent > 0 || PQisBusy(handle) != 0) {
      if (!wait_while_alive(handle, unsent > 0, limit, alive)) {
        PQclear(kept);
        return nullptr;
      }
      // A failure is reported by PQgetResult().
      if (PQconsumeInput(handle) == 0) break;
      if (unsent > 0) unsent = PQflush(handle);
    }
    PGresult* result = PQgetResult(handle);
    if (result == nullptr) return kept != nullptr ? kept : PQmakeEmptyPGresult(handle, PGRES_FATAL_ERROR);
    if (kept != nullptr && PQresultStatus(kept) == PGRES_FATAL_ERROR) {
      PQclear(result);
    } else {
      PQclear(kept);
      kept = result;
    }
  }
}

}  // namespace ugoki::store
