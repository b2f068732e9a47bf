# shellcheck shell=bash
# Packages of another machine, found by a package manager with a state of its own: `source` it after lib.sh.

# Of the main suite only: its security updates do not come out at the same time for every machine, and one tree must not
# mix their versions.
main_suite() {
  if [[ -n ${SINEW_SYSROOT_SOURCE:-} ]]; then
    say "$SINEW_SYSROOT_SOURCE"
    return
  fi
  local suite
  suite=$(sed -n 's/^VERSION_CODENAME=//p' /etc/os-release)
  # shellcheck disable=SC2016  # apt's and dpkg's own names in dollars
  apt-get indextargets --format '$(REPO_URI) $(CODENAME) $(COMPONENT)' 'Created-By: Packages' |
    awk -v suite="$suite" '$2 == suite && $3 == "main" { print "deb", $1, $2, $3; exit }'
}

# own_apt WORK ARCH SOURCE: a package manager's state of its own in WORK, so that the system's is neither read nor changed.
own_apt() {
  mkdir -p "$1"/{lists/partial,archives/partial,empty}
  : >"$1/status"
  say "$3" >"$1/sources.list"
  cat >"$1/apt.conf" <<TEXT
APT::Architecture "$2";
APT::Architectures { "$2"; };
APT::Install-Recommends "false";
APT::Sandbox::User "";
Acquire::Languages "none";
Acquire::Retries "3";
Dir::State "$1";
Dir::State::status "$1/status";
Dir::Cache "$1";
Dir::Etc::sourcelist "$1/sources.list";
Dir::Etc::sourceparts "$1/empty";
Dir::Etc::preferences "$1/empty/none";
Dir::Etc::preferencesparts "$1/empty";
TEXT
}
