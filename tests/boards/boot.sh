#!/usr/bin/env bash
# Boots an emulated board with Debian's kernel for it and runs one command there, with the libraries of the board's sysroot
# and the repository, read-only, at its own path. The command's output and exit code are this script's.
#
#   tests/boards/boot.sh mipsel build/mipsel/bin/sinew --version
#   tests/boards/boot.sh --limit 60 armhf busybox uname -a
#   tests/boards/boot.sh --shell arm64              a shell on this terminal instead; `exit` ends it
#
# BOARD: arm64 and armhf (PREEMPT_RT, 2 processors), mipsel (malta, one processor). It reaches this host's 127.0.0.1 as
# 10.0.2.2. The first word's file is copied into the board's memory: from a shared folder MIPS cannot start a program.
# build/boards/BOARD/out keeps what the board wrote: stdout, stderr, status, memory (of the command, in kB), kernel.log,
# up_cs (hundredths of a second from the kernel's start to the command); build/logs/boards-BOARD.log its console.
# Exit: the command's; 125 when the board did not come to its end within --limit seconds (900); 124 when all was well but
# for reads or writes across words, which mipsel's kernel counts (`unaligned`).
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../../tools/lib.sh"
source "$root/tests/vm/kernel.sh"

limit_s=900 shell=0
while [[ ${1:-} == --* ]]; do
  case $1 in
    --limit)
      limit_s=${2:-}
      [[ $limit_s =~ ^[0-9]+(\.[0-9]+)?$ ]] || die "--limit: ${limit_s:-nothing}: no number of seconds"
      shift 2
      ;;
    --shell) shell=1 limit_s=36000 && shift ;;
    *) die "$1: --limit SECONDS or --shell" ;;
  esac
done
board=${1:?arm64, armhf or mipsel}
shift
((shell || $#)) || die "which command runs on $board?"
"$root/tests/boards/setup.sh" "$board"
sysroot=${SINEW_SYSROOTS:-$root/build/sysroot}/$board
[[ -d $sysroot ]] || die "no sysroot: toolchains/sysroot.sh $board"
kernel=$root/build/boards/$board out=$root/build/boards/$board/out console=$logs/boards-$board.log
exec {lock}>"$kernel/lock"
flock -n "$lock" || die "$board is running already"
rm -rf "$out"
mkdir -p "$out" "$logs"

# job COMMAND...: the command as the board's shell reads it.
job() {
  local file below
  if [[ -f $1 ]]; then
    file=$(realpath "$1") below=$(realpath "$root")
    [[ $file == "$below"/* ]] || die "$1: not below $root, which is what the board sees"
    printf 'cp %q /tmp/\n' "$root/${file#"$below"/}"
    set -- "/tmp/$(basename "$1")" "${@:2}"
  fi
  printf 'exec'
  printf ' %q' "$@"
  printf '\n'
}
if ((shell)); then say "setsid -c sh </dev/$(machine_of "$board" && say "$port") >/dev/console 2>&1"; else job "$@"; fi >"$out/job"

machine_of "$board"
share source "$root" readonly=on
share sysroot "$sysroot" readonly=on
share out "$out"
machine+=(-m 512 -accel "tcg,thread=multi" -nic "user,model=virtio-net-pci,restrict=off")
[[ $board == mipsel ]] || machine+=(-smp 2)
words="console=$port mitigations=off loglevel=4 panic=-1 nokaslr board.source=$root"
qemu=("${machine[@]}" -kernel "$(echo "$kernel"/boot/vmlinu[xz]-*)"
  -initrd "$kernel/initramfs.gz" -append "$words")
if ((shell)); then
  exec timeout -k 5 "$limit_s" "${qemu[@]}" -serial stdio
fi
trap end_limited EXIT
status=0
limited "$limit_s" "${qemu[@]}" -serial "file:$console" >"$console.qemu" 2>&1 || status=$?
[[ ! -f $out/stdout ]] || cat "$out/stdout"
[[ ! -f $out/stderr ]] || cat "$out/stderr" >&2
if ((status != 0)) || [[ ! -f $out/kernel.log ]] || ! grep -q '^board: came to its end' "$console"; then
  {
    ((status != 124 && status != 137)) || say "stopped after $limit_s s"
    tail -n 20 "$console.qemu" "$console"
    say "boards: $board did not come to its end (qemu: $status, log: ${console#"$root"/})"
  } >&2
  exit 125
fi
status=$(cat "$out/status")
if [[ $board == mipsel ]]; then
  unaligned=$(cat "$out/unaligned")
  if ((unaligned != 0)); then
    say "boards: $board: $unaligned reads or writes across words, which the kernel had to take apart" >&2
    ((status)) || status=124
  fi
fi
exit "$status"
