# limit_s: 150
# V4l2Camera on vivid: formats, rates, controls, memory of the reader, unbinding and binding again.
modprobe vivid n_devs=1 node_types=0x1
SINEW_V4L2=/dev/video0 gtest hal/hal_linux_v4l2_camera_test --gtest_filter='V4l2*OnKernel.*'
modprobe -r vivid
