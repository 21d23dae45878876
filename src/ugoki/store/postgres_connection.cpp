// A library in a PostgreSQL database, through libpq.

#include <libpq-fe.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <iterator>
#include <map>
#include <thread>
#include <utility>

#include "ugoki/store/connection.h"
#include "ugoki/store/postgres_wait.h"

namespace ugoki::store {
namespace {

const Dialect postgres_dialect = {
    .postgres = true,
    .now = R"(to_char(clock_timestamp() AT TIME ZONE 'UTC', 'YYYY-MM-DD"T"HH24:MI:SS.MS"Z"'))",
    .instr = "strpos",
    // The subquery hides the value of {query} from the planner. Otherwise the planner may choose a scan that reads the words of every row.
    .match =
        "SELECT o.entry AS no, o.id, o.name_key, o.changed, o.duration_ms FROM entry_order o WHERE terms_of(o.entry) @@ "
        "(SELECT {query}::text::tsquery)",
    .phrase_condition = " AND EXISTS (SELECT 1 FROM entry_text t WHERE t.entry = o.entry AND t.terms @@ (SELECT {query}::text::tsquery))",
    .hit_source = "hit e",
    .sort_factor = 3,
    .scan_fraction = 1.0 / 16,
    .lock_suffix = " FOR UPDATE",
};

/// Settings of every connection. search_path: unqualified table names refer to the schema `ugoki`. synchronous_commit: an acknowledged
/// change is on the server's disk.
constexpr const char* session_settings =
    "SET search_path = ugoki; SET synchronous_commit = on; SET lock_timeout = '10s'; SET jit = off; SET client_min_messages = warning; "
    "SET standard_conforming_strings = on; SET plan_cache_mode = force_custom_plan; SET idle_in_transaction_session_timeout = '10min'";
/// Every transaction that changes the library notifies the other connections on this channel.
constexpr const char* listen = "LISTEN ugoki_library";

// Deleters for libpq objects.
struct ResultEnd {
  void operator()(PGresult* r) const { PQclear(r); }
};
using Answer = std::unique_ptr<PGresult, ResultEnd>;
struct ConnectionEnd {
  void operator()(PGconn* c) const { PQfinish(c); }
};
using Handle = std::unique_ptr<PGconn, ConnectionEnd>;
struct OptionsEnd {
  void operator()(PQconninfoOption* o) const { PQconninfoFree(o); }
};

/// The secret parts of an address: the options that libpq marks as secret. Because the address may be malformed, the result also has every
/// text between the user's name and the last '@' that may be part of a password.
std::vector<std::string> secrets_of(const std::string& address) {
  std::vector<std::string> secrets;
  char* message = nullptr;
  const std::unique_ptr<PQconninfoOption, OptionsEnd> options(PQconninfoParse(address.c_str(), &message));
  PQfreemem(message);
  for (const PQconninfoOption* o = options.get(); o != nullptr && o->keyword != nullptr; ++o)
    if (o->val != nullptr && o->val[0] != '\0' && o->dispchar[0] == '*') secrets.emplace_back(o->val);
  const std::size_t begin = address.find("://"), end = address.rfind('@');
  if (begin == std::string::npos || end == std::string::npos || end < begin + 3) return secrets;
  const std::string_view credentials = std::string_view(address).substr(begin + 3, end - begin - 3);
  for (std::size_t at = credentials.find(':'); at < credentials.size();) {
    const std::size_t next = std::min(credentials.find_first_of(":@/", at + 1), credentials.size());
    if (next > at + 1) secrets.emplace_back(credentials.substr(at + 1, next - at - 1));
    at = next;
  }
  return secrets;
}

class PostgresConnection final : public Connection {
 public:
  PostgresConnection(std::string address, bool read_only)
      : address_(std::move(address)), location_(without_password(address_)), secrets_(secrets_of(address_)), read_only_(read_only) {}

  const Dialect& dialect() const override { return postgres_dialect; }
  const std::string& location() const override { return location_; }
  bool should_retry() const override { return retry_; }

  Result<void> connect() {
    prepared_.clear();
    missed_ = listening_;
    silent_ = false;
    const auto begun = std::chrono::steady_clock::now();
    handle_.reset(PQconnectdbParams(keys, values().data(), 1));
    const bool waited = std::chrono::steady_clock::now() - begun >= max_silence;  // the server, or the network, gave no answer at all
    if (waited && lost()) return silent();
    if (lost())
      return fail(ErrorCode::io, location_,
                  "The database server cannot be reached" + detail(handle_ ? PQerrorMessage(handle_.get()) : "") + ".",
                  "Check the address, that the server runs, and the user name and password (also in ~/.pgpass or PGPASSWORD).");
    PQsetNoticeProcessor(handle_.get(), [](void*, const char*) {}, nullptr);
    if (PQsetnonblocking(handle_.get(), 1) != 0) return problem_of(nullptr);
    if (Result<void> set = run(session_settings); !set) return set;
    if (Result<void> set = limit_statements(true); !set) return set;
    if (listening_)
      if (Result<void> done = run(listen); !done) return done;
    if (read_only_) return run("SET default_transaction_read_only = on");
    return {};
  }

  using Connection::query;
  Result<Rows> query(std::string_view sql, std::span<const Value> parameters) override {
    const Result<Answer> answer = execute(sql, parameters, 0);
    if (!answer) return fail(answer.error());
    const int rows = PQntuples(answer->get()), columns = PQnfields(answer->get());
    Rows out(columns);
    for (int r = 0; r < rows; ++r)
      for (int c = 0; c < columns; ++c)
        out.add(std::string(PQgetvalue(answer->get(), r, c), static_cast<std::size_t>(PQgetlength(answer->get(), r, c))),
                PQgetisnull(answer->get(), r, c) != 0);
    return out;
  }

  Result<std::optional<std::vector<std::byte>>> bytes(std::string_view sql, std::span<const Value> parameters) override {
    const Result<Answer> answer = execute(sql, parameters, 1);
    if (!answer) return fail(answer.error());
    if (PQntuples(answer->get()) == 0) return std::nullopt;
    const auto* p = reinterpret_cast<const std::byte*>(PQgetvalue(answer->get(), 0, 0));
    return std::vector<std::byte>(p, p + PQgetlength(answer->get(), 0, 0));
  }

  Result<void> script(const std::string& sql) override { return unlimited(sql.c_str()); }

  Result<void> begin(Access access) override {
    retry_ = false;
    if (Result<void> alive = reconnect_if_lost(); !alive) return alive;
    Result<void> begun =
        run(access == Access::write ? "BEGIN ISOLATION LEVEL READ COMMITTED" : "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY");
    if (!begun && lost() && !open_ &&
        !silent_) {  // the server restarted since the last statement; no transaction was open, so nothing is lost
      if (Result<void> again = connect(); !again) return again;
      begun = run(access == Access::write ? "BEGIN ISOLATION LEVEL READ COMMITTED" : "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY");
    }
    open_ = begun.has_value();
    return begun;
  }

  Result<void> commit() override {
    Result<Rows> number = query(
        "SELECT pg_current_xact_id_if_assigned()::text, "
        "CASE WHEN pg_current_xact_id_if_assigned() IS NOT NULL THEN pg_notify('ugoki_library', '')::text END");
    if (!number) {
      rollback();
      return fail(std::move(number.error()));
    }
    const std::string transaction = number->is_null(0, 0) ? "" : number->text(0, 0);
    Result<void> done = run("COMMIT");
    open_ = false;
    if (!done && lost()) {
      retry_ = false;
      return resolve_commit(transaction);
    }
    return done;
  }

  void rollback() override {
    if (open_ && handle_ && !lost()) {
      const bool retry = retry_;
      (void)run("ROLLBACK");
      retry_ = retry;
    }
    open_ = false;
  }

  Result<void> check(Error& problems) override {
    const Result<Rows> settings =
        query("SELECT name, setting FROM pg_settings WHERE name IN ('fsync', 'full_page_writes') AND setting = 'off'");
    if (!settings) return fail(settings.error());
    for (std::size_t i = 0; i < settings->size(); ++i)
      problems.add(ErrorCode::unsupported, location_,
                   "The server runs with " + settings->text(i, 0) + " = off: a power cut can destroy saved data.",
                   "Ask the server's administrator to set it to on.");
    return {};
  }

  Result<void> tidy() override { return unlimited("VACUUM (ANALYZE, SKIP_LOCKED) entry, version, tag, entry_text, entry_order"); }

  Result<bool> changed_elsewhere() override {
    const bool first = !listening_;
    // If the connection has ended, the first call may still read its last message; the second call then reports the end.
    for (int i = 0; i < 2; ++i)
      if (!lost() && PQconsumeInput(handle_.get()) == 0) handle_.reset();
    if (Result<void> alive = reconnect_if_lost(); !alive) return fail(std::move(alive.error()));
    if (first)
      if (Result<void> done = run(listen); !done) return fail(std::move(done.error()));
    listening_ = true;
    bool changed = std::exchange(missed_, false);
    while (PGnotify* notification = PQnotifies(handle_.get())) {
      changed = changed || notification->be_pid != PQbackendPID(handle_.get());
      PQfreemem(notification);
    }
    return changed && !first;
  }

 private:
  // Options in the address (dbname) override the options before it in this list.
  static constexpr const char* keys[] = {"connect_timeout",  "keepalives_idle",  "keepalives_interval",
                                         "keepalives_count", "tcp_user_timeout", "application_name",
                                         "client_encoding",  "dbname",           nullptr};
  [[nodiscard]] std::array<const char*, std::size(keys)> values() const {
    return {connect_limit, "10", "5", "3", "10000", "ugoki", "UTF8", address_.c_str(), nullptr};
  }
  /// True if the server accepts connections.
  [[nodiscard]] bool alive() const {
    const Handle probe(PQconnectdbParams(keys, values().data(), 1));
    return PQstatus(probe.get()) == CONNECTION_OK;
  }
  /// Waits for the result of the statement that was sent. Null: the server does not respond; the connection is closed, and silent_ is set.
  [[nodiscard]] Answer wait(std::chrono::seconds limit = max_statement_silence) {
    Answer answer(wait_for_result(handle_.get(), limit, [this] { return alive(); }));
    silent_ = !answer;
    if (silent_) handle_.reset();
    return answer;
  }
  [[nodiscard]] std::unexpected<Error> silent() const {
    return fail(ErrorCode::io, location_, "The database server does not respond; an unfinished change was not saved.",
                "Check that the server runs and that the network works, then try again.");
  }
  /// Sets or removes the server's time limit for a statement.
  Result<void> limit_statements(bool limited) {
    return run(limited ? std::string("SET statement_timeout = '").append(statement_limit).append("'").c_str()
                       : "SET statement_timeout = 0");
  }
  /// Runs statements without the server's time limit, because upgrades and VACUUM may take hours.
  Result<void> unlimited(const char* sql) {
    if (Result<void> set = limit_statements(false); !set) return set;
    Result<void> done = run(sql, std::chrono::hours(24));
    if (!done && open_) return done;  // the rollback of the open transaction restores the time limit
    Result<void> set = limit_statements(true);
    return done ? set : done;
  }

  /// True if there is no working connection, as far as libpq knows.
  [[nodiscard]] bool lost() const { return !handle_ || PQstatus(handle_.get()) != CONNECTION_OK; }
  /// Connects again if the connection is known to be lost.
  Result<void> reconnect_if_lost() { return lost() ? connect() : Result<void>{}; }

  /// libpq's message in brackets, to be appended to an error message; empty if libpq's message contains a secret.
  [[nodiscard]] std::string detail(std::string text) const {
    while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
    std::ranges::replace(text, '\n', ' ');
    std::ranges::replace(text, '\t', ' ');
    for (const std::string& secret : secrets_)
      if (text.find(secret) != std::string::npos) return "";
    return text.empty() ? "" : " (" + text + ")";
  }

  /// To be called if the connection was lost during a COMMIT: reconnects and asks the server whether the transaction was committed.
  /// @param transaction id of the transaction; empty if it changed nothing
  Result<void> resolve_commit(const std::string& transaction) {
    if (transaction.empty()) return {};
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    for (int attempt = 0; attempt < 20 && std::chrono::steady_clock::now() < end; ++attempt) {
      std::this_thread::sleep_for(std::chrono::milliseconds(attempt < 5 ? 100 : 500));
      if (!connect()) continue;
      const Value number(transaction);
      const Result<Rows> status = query("SELECT pg_xact_status(?1::text::xid8)", std::span<const Value>(&number, 1));
      if (!status) continue;
      if (status->text(0, 0) == "committed") return {};
      if (status->text(0, 0) == "aborted")
        return fail(ErrorCode::io, location_, "The connection to the database server was lost; this change was not saved.", "Try again.");
    }
    return fail(ErrorCode::io, location_, "The connection to the database server was lost while saving, and the server does not answer.",
                "When the server runs again, check whether the entry has the new version before you save again.");
  }

  /// The error of a failed statement, by its SQLSTATE code. Sets retry_ after a conflict with a concurrent transaction.
  std::unexpected<Error> problem_of(const PGresult* answer) {
    if (silent_) return silent();
    const char* field = answer != nullptr ? PQresultErrorField(answer, PG_DIAG_SQLSTATE) : nullptr;
    const std::string state = field != nullptr ? field : "";
    const char* primary = answer != nullptr ? PQresultErrorField(answer, PG_DIAG_MESSAGE_PRIMARY) : nullptr;
    const std::string details = detail(primary != nullptr ? primary : PQerrorMessage(handle_.get()));
    if (lost() || state.starts_with("57P") || state.starts_with("08"))
      return fail(ErrorCode::io, location_,
                  "The connection to the database server was lost" + details + "; an unfinished change was not saved.",
                  "Try again when the server runs.");
    if (state == "40001" || state == "40P01" || state == "23503" || state == "23505") {
      retry_ = true;
      return fail(ErrorCode::conflict, location_, "Another program changed the same entries at the same time" + details + ".",
                  "Try again.");
    }
    if (state == "55P03")
      return fail(ErrorCode::conflict, location_, "The database is locked by another program.",
                  "Wait until it has finished, then try again.");
    if (state == "57014")
      return fail(ErrorCode::io, location_, "The database server needed more than " + std::string(statement_limit) + " for one statement.",
                  "Try again when the server is less busy, or ask its administrator.");
    if (state == "25006") return fail(ErrorCode::io, location_, "The database is opened read-only.", "Open it for writing.");
    if (state.starts_with("42501"))
      return fail(ErrorCode::io, location_, "The database user does not have the permission" + details + ".",
                  "Ask the library's owner to grant the rights listed in docs/library.md, section \"A library for a team\".");
    if (state.starts_with("53"))
      return fail(ErrorCode::io, location_, "The database server is out of disk space, memory or connections" + details + ".",
                  "Free resources on the server and try again.");
    return fail(ErrorCode::io, location_, "The database reported an error" + details + ".",
                "Try again, or ask the server's administrator.");
  }

  /// Runs statements without parameters. @param limit as for wait_for_result()
  Result<void> run(const char* sql, std::chrono::seconds limit = max_statement_silence) {
    if (!handle_) return problem_of(nullptr);
    if (PQsendQuery(handle_.get(), sql) == 0) return problem_of(nullptr);
    const Answer answer = wait(limit);
    const ExecStatusType status = PQresultStatus(answer.get());
    if (status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK || status == PGRES_EMPTY_QUERY) return {};
    return problem_of(answer.get());
  }

  /// Runs one statement, after reconnecting if necessary. @param format format of the result columns: 0 is text, 1 is binary
  Result<Answer> execute(std::string_view sql, std::span<const Value> parameters, int format) {
    retry_ = false;
    if (!open_) {
      if (Result<void> alive = reconnect_if_lost(); !alive) return fail(std::move(alive.error()));
    }
    Result<Answer> answer = send(sql, parameters, format);
    if (!answer && lost() && !open_ && !silent_) {  // outside a transaction the statement can be repeated on a new connection
      if (Result<void> again = connect(); !again) return fail(std::move(again.error()));
      answer = send(sql, parameters, format);
    }
    return answer;
  }

  /// Sends one statement as a prepared statement. Prepared statements are cached.
  Result<Answer> send(std::string_view sql, std::span<const Value> parameters, int format) {
    if (!handle_) return problem_of(nullptr);
    constexpr std::size_t max_prepared = 200;  // the cache is cleared when it is full
    auto known = prepared_.find(sql);
    if (known == prepared_.end()) {
      if (prepared_.size() >= max_prepared) {
        if (Result<void> gone = run("DEALLOCATE ALL"); !gone) return fail(std::move(gone.error()));
        prepared_.clear();
      }
      std::string text(sql), name = "s" + std::to_string(prepared_.size());
      std::ranges::replace(text, '?', '$');
      if (PQsendPrepare(handle_.get(), name.c_str(), text.c_str(), 0, nullptr) == 0) return problem_of(nullptr);
      const Answer made = wait();
      if (PQresultStatus(made.get()) != PGRES_COMMAND_OK) return problem_of(made.get());
      known = prepared_.emplace(std::string(sql), std::move(name)).first;
    }
    std::vector<std::string> texts(parameters.size());
    std::vector<const char*> values(parameters.size());
    std::vector<int> lengths(parameters.size()), formats(parameters.size());
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const Value& v = parameters[i];
      if (v.type == Value::Type::bytes) {
        values[i] = v.bytes.empty() ? "" : reinterpret_cast<const char*>(v.bytes.data());
        lengths[i] = static_cast<int>(v.bytes.size());
        formats[i] = 1;
        continue;
      }
      if (v.type != Value::Type::null) {
        texts[i] = v.type == Value::Type::integer ? std::to_string(v.number) : std::string(v.text);
        values[i] = texts[i].c_str();
      }
    }
    if (PQsendQueryPrepared(handle_.get(), known->second.c_str(), static_cast<int>(parameters.size()), values.data(), lengths.data(),
                            formats.data(), format) == 0)
      return problem_of(nullptr);
    Answer answer = wait();
    const ExecStatusType status = PQresultStatus(answer.get());
    if (status != PGRES_COMMAND_OK && status != PGRES_TUPLES_OK) return problem_of(answer.get());
    return answer;
  }

  std::string address_, location_;
  std::vector<std::string> secrets_;
  bool read_only_, open_ = false, retry_ = false;
  bool silent_ = false;     ///< true: the last statement ended because the server did not respond
  bool listening_ = false;  ///< true: changed_elsewhere() has been called
  bool missed_ = false;     ///< true: notifications may have been lost with an earlier connection
  Handle handle_;
  std::map<std::string, std::string, std::less<>> prepared_;  ///< names of the prepared statements, by their SQL text
};

}  // namespace

bool is_postgres(std::string_view location) { return location.starts_with("postgresql://") || location.starts_with("postgres://"); }

std::string without_password(std::string_view location) {
  if (!is_postgres(location)) return std::string(location);
  std::string out(location);
  const std::size_t begin = out.find("://") + 3, end = out.rfind('@');
  if (end != std::string::npos && out.find('?') < end) return out.substr(0, begin) + "***";  // it is unclear where the password ends
  if (end != std::string::npos && end > begin) {
    const std::size_t colon = out.find(':', begin);
    if (colon < end) out.replace(colon, end - colon, "");
  }
  for (const std::string_view secret : {"password=", "sslpassword="}) {
    const std::size_t query = out.find('?');
    for (std::size_t at = query; at < out.size();) {
      const std::size_t next = std::min(out.find('&', at + 1), out.size());
      if (std::string_view(out).substr(at + 1).starts_with(secret)) {
        out.replace(at + 1 + secret.size(), next - at - 1 - secret.size(), "***");
        at = std::min(out.find('&', at + 1), out.size());
      } else {
        at = next;
      }
    }
  }
  return out;
}

Result<std::unique_ptr<Connection>> postgres_connection(const std::string& address, bool read_only) {
  auto connection = std::make_unique<PostgresConnection>(address, read_only);
  if (Result<void> done = connection->connect(); !done) return fail(std::move(done.error()));
  return connection;
}

}  // namespace ugoki::store
