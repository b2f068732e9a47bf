#!/usr/bin/env bash
# Boots the kernel of tests/vm/setup.sh in qemu and runs the sub-tests of one folder there, one after the other.
#
#   tests/vm/boot.sh board            one boot, every sub-test of tests/vm/board
#   tests/vm/boot.sh board can v4l2   only these
#   tests/vm/boot.sh --shell board    the same machine with a shell on this terminal; `exit` ends it
#   tests/vm/boot.sh --arch arm64 ... another machine (amd64): the programs of build/arm64
#
# board:  two processors, as fast as the host lets them: whether things work.
# icount: one processor that takes 4 ns of the guest's time for each instruction, so that times do not depend on the
#         host: how late things are.
# buses:  the same with 1 ns for each instruction: as many frames a second as a board has, however slow the host is.
# head:   the same with more memory, for a robot and the world around it.
# team:   as board, with a network to the host and a calendar that is years ahead. The host is 10.0.2.2, also its loopback
#         interface; what comes to a UDP port of the host that is chosen here goes to port 4580 of the guest. The part of a
#         sub-test on the host, NAME.host.py, runs from before the boot, and shares the folder results/team/NAME with the guest.
#
# For each sub-test build/vm/results/FOLDER/NAME.log is its output, NAME.result its exit code and its seconds; kernel.log
# is the kernel's. Exit: 0 when the guest came to the end, whatever its sub-tests' results.
# shellcheck disable=SC2054  # commas inside of qemu's options
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../../tools/lib.sh"
source "$root/tests/vm/kernel.sh"

shell=0 limit_s=1500 arch=amd64
while [[ ${1:-} == --* ]]; do
  case $1 in
    --shell) shell=1 limit_s=36000 && shift ;;
    --arch) arch=${2:?"amd64 or arm64"} && shift 2 ;;
    *) die "$1: --shell or --arch ARCH" ;;
  esac
done
folder=${1:?"board, team, icount, buses or head"}
shift
here=$root/tests/vm
[[ -d $here/$folder ]] || die "$folder: no such folder of sub-tests in tests/vm"
names=("$@")
if ((${#names[@]} == 0)); then
  for file in "$here/$folder"/*.sh; do
    only=$(sed -n 's/^# only: //p' "$file")
    [[ -n $only && $only != "$arch" ]] || names+=("$(basename "$file" .sh)")
  done
fi
for name in "${names[@]}"; do
  [[ -f $here/$folder/$name.sh ]] || die "$name: no such sub-test in tests/vm/$folder"
done

"$here/setup.sh" "$arch"
vm=$root/build/vm/$arch
machine_of "$arch"
case $arch in
  amd64) build=$root/build/release results=$root/build/vm/results/$folder console=$logs/vm-$folder.log ;;
  arm64) build=$root/build/arm64 results=$root/build/vm/results/$arch-$folder console=$logs/vm-$arch-$folder.log ;;
esac
rm -rf "$results"
mkdir -p "$results" "$logs"
{
  printf 'root=%q\n' "$root"
  printf 'build=%q\n' "$build"
  printf 'folder=%q\n' "$folder"
  printf 'shell=%q\n' "$shell"
  printf 'names=(%s)\n' "${names[*]@Q}"
} >"$results/job"

machine+=(-m 1024 -nic none)
share host / readonly=on
share results "$results"
case $folder in
  board)
    machine+=(-accel tcg,thread=multi -smp 2
      -object can-bus,id=can -device kvaser_pci,canbus=can -device kvaser_pci,canbus=can)
    ;;
  team)
    guest_port=$(python3 -c 'import socket as s; p = s.socket(type=s.SOCK_DGRAM); p.bind(("127.0.0.1", 0)); print(p.getsockname()[1])')
    machine+=(-accel tcg,thread=multi -smp 2 -rtc base=2040-05-06T07:08:09
      -netdev "user,id=net,ipv6=off,hostfwd=udp:127.0.0.1:$guest_port-:4580" -device virtio-net-pci,netdev=net,romfile=)
    ;;
  buses)
    machine+=(-accel tcg -smp 1 -icount shift=0,sleep=off -rtc clock=vm -seed 1
      -object can-bus,id=can -device kvaser_pci,canbus=can -device kvaser_pci,canbus=can)
    ;;
  head) machine+=(-accel tcg -smp 1 -m 2048 -icount shift=0,sleep=off -rtc clock=vm -seed 1) ;;
  icount)
    machine+=(-accel tcg -smp 1 -icount shift=2,sleep=off -rtc clock=vm -seed 1)
    [[ $arch != arm64 ]] || machine+=(-device i6300esb -action watchdog=shutdown) # a hand at the power button: power_button.sh
    ;;
  *) die "$folder: no machine is described for it" ;;
esac
words="console=$port mitigations=off loglevel=4 panic=-1 nokaslr tsc=reliable"
# No sub-test is about the guards of the kernel's own memory, nor about its accounting of waiting; they are a good part of
# the cost of a frame on a virtual CAN bus.
words+=" init_on_alloc=0 randomize_kstack_offset=off hardened_usercopy=off psi=0 apparmor=0 audit=0"
words+=" vm.kernel=$vm vm.source=$root vm.results=$results"
[[ ! -d $vm/tree ]] || words+=" vm.tree=$vm/tree"
# Counted time leaps from timer to timer while the guest has nothing to do, also when it waits for a file of the host:
# minutes, where the host is slow. So it always has something to do.
[[ $folder =~ ^(board|team)$ ]] || words+=" vm.busy"

# In real time a guest of amd64 reads the host's counter.
[[ ! $folder =~ ^(board|team)$ || $arch != amd64 ]] || words+=" tsc_early_khz=$("$build/tests/vm/vm_tsc_khz")"

start=$(now_s)
qemu=("${machine[@]}" -kernel "$(echo "$vm"/boot/vmlinuz-*)"
  -initrd "$vm/initramfs.gz" -append "$words")
if ((shell)); then
  exec timeout -k 5 "$limit_s" "${qemu[@]}" -serial stdio # in its place: one of a group of its own may not read a terminal
fi
host_pids=()
end_host_parts() {
  ((${#host_pids[@]})) || return 0
  kill "${host_pids[@]}" 2>/dev/null || true
  wait "${host_pids[@]}" 2>/dev/null || true
}
trap 'end_limited; end_host_parts' EXIT
for name in "${names[@]}"; do
  host_part=$here/$folder/$name.host.py
  [[ -f $host_part ]] || continue
  mkdir "$results/$name"
  python3 -B "$host_part" "$root/build/release" "$results/$name" "$guest_port" >"$results/$name.host.log" 2>&1 </dev/null &
  host_pids+=($!)
done
status=0
limited "$limit_s" "${qemu[@]}" -serial "file:$console" >"$console.qemu" 2>&1 || status=$?
if [[ ! -f $results/finished ]]; then
  tail -n 40 "$console.qemu" "$console"
  ((status != 124)) || say "stopped after $limit_s s"
  die "the guest did not come to the end of $folder (log: ${console#"$root"/})"
fi
for name in "${names[@]}"; do
  read -r code took <"$results/$name.result" || code=missing took=0
  say "$name: $([[ $code == 0 ]] && echo passed || echo "FAILED ($code)") in $took s"
done
say "vm: $folder: $(cat "$results/finished"), $(minutes $(($(now_s) - start))) with the boot"
