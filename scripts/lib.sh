# Shared functions of ./start, ./test and ./bench: messages with times, and builds.
# Source it with `root` set to the project's folder. Logs are written to build/log/.

log_dir="$root/build/log"
mkdir -p "$log_dir"

now() { date +%s%3N; }
seconds_since() { local ms=$(($(now) - $1)); printf '%d.%01d s' $((ms / 1000)) $((ms % 1000 / 100)); }
message() { printf '%s\n' "$*"; }

# step NAME LOG COMMAND...: runs a command, with its output in build/log/LOG.log. Prints one line with the time, and the log's end on failure.
step() {
  local name=$1 log="$log_dir/$2.log" began
  shift 2
  began=$(now)
  printf '%-34s ' "$name"
  [ -t 1 ] || printf '...\n'
  if "$@" >"$log" 2>&1; then
    [ -t 1 ] || printf '%-34s ' "$name"
    printf 'done in %s\n' "$(seconds_since "$began")"
  else
    printf 'FAILED after %s. The end of %s:\n\n' "$(seconds_since "$began")" "$log"
    tail -n 60 "$log"
    return 1
  fi
}

# Allows one build at a time in this folder: locks build/.lock on descriptor 9 until release_lock.
take_lock() {
  exec 9>"$root/build/.lock"
  flock -n 9 && return 0
  message "waiting for another ./start, ./test or ./bench that builds in this folder"
  flock 9
}
release_lock() {
  flock -u 9
  exec 9>&-
}

# Number of build jobs: one per core, but at least 1.5 GB of available memory for each.
build_jobs() {
  local cores memory
  cores=$(nproc)
  memory=$(awk '/^MemAvailable/ {print int($2 / 1500000)}' /proc/meminfo 2>/dev/null || echo 1)
  [ "$memory" -ge 1 ] || memory=1
  echo $((cores < memory ? cores : memory))
}

export CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime # ccache needs them for precompiled headers

# configure PRESET [cmake options]: runs cmake if the preset was not configured yet or the options have changed.
configure() {
  local preset=$1 dir="$root/build/$1"
  shift
  if [ -f "$dir/build.ninja" ] && [ "$*" = "$(cat "$dir/.configured" 2>/dev/null || echo -)" ]; then return 0; fi
  if command -v ccache >/dev/null; then
    export CMAKE_C_COMPILER_LAUNCHER=ccache CMAKE_CXX_COMPILER_LAUNCHER=ccache
  fi
  step "configure ($preset)" "configure-$preset" cmake -S "$root" --preset "$preset" "$@" && printf '%s' "$*" >"$dir/.configured"
}

# build PRESET [targets]: runs ninja, with its progress on a terminal, otherwise with its output in the log.
build() {
  local preset=$1 dir="$root/build/$1" began
  shift
  began=$(now)
  if [ -t 1 ]; then
    message "build ($preset)"
    ninja -C "$dir" -j "$(build_jobs)" "$@" || return 1
    printf '%-34s done in %s\n' "build ($preset)" "$(seconds_since "$began")"
  else
    step "build ($preset)" "build-$preset" ninja -C "$dir" -j "$(build_jobs)" "$@"
  fi
}

# Hash of the names, sizes and times of the page's source files.
web_sources_hash() {
  (cd "$root/web" && find . \( -name node_modules -o -name dist -o -name test-results \) -prune -o -type f -printf '%p %s %T@\n' | sort | sha256sum)
}

# Installs the packages of web/package-lock.json into web/node_modules.
web_packages() {
  local stamp="$root/web/node_modules/.installed" wanted
  wanted=$(cd "$root/web" && sha256sum package.json package-lock.json && node --version)
  [ "$wanted" != "$(cat "$stamp" 2>/dev/null || true)" ] || return 0
  step "web packages (npm ci)" npm-ci npm --prefix "$root/web" ci --no-audit --no-fund && printf '%s' "$wanted" >"$stamp"
}

# Rebuilds web/dist if a source file changed.
web_build() {
  local stamp="$root/web/dist/.built" wanted
  web_packages || return 1
  wanted=$(web_sources_hash)
  [ "$wanted" != "$(cat "$stamp" 2>/dev/null || true)" ] || return 0
  step "web page (vite)" web-build npm --prefix "$root/web" run build && printf '%s' "$wanted" >"$stamp"
}

# Builds the player for exported pages: the engine as WebAssembly and the page around it, in build/release/share/ugoki.
player_build() {
  local folder="$root/build/release/share/ugoki" stamp wanted
  stamp="$folder/.built"
  configure wasm && build wasm ugoki_player_wasm ugoki_planar_wasm && web_packages || return 1
  wanted=$(web_sources_hash; cat "$root"/build/wasm/bin/ugoki_{player,planar}.wasm | sha256sum)
  [ "$wanted" != "$(cat "$stamp" 2>/dev/null || true)" ] || return 0
  step "player page (vite)" player-build node "$root/web/player/build.mjs" "$root/build/wasm/bin/ugoki_player.wasm" "$folder" && cp "$root/build/wasm/bin/ugoki_planar.wasm" "$folder" && printf '%s' "$wanted" >"$stamp"
}
