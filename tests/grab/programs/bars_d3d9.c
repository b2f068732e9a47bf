/* bars_d3d9.exe FRAMES: frame numbers by Direct3D 9, for Wine, which draws them by OpenGL. */
#define COBJMACROS
#include <d3d9.h>
#include <stdio.h>
#include <stdlib.h>
#include <windows.h>

enum { kBars = 16, kBorder = 8, kWidth = 640, kHeight = 480 };

static void fill(IDirect3DDevice9* device, int x, int y, int width, int height, D3DCOLOR colour) {
  D3DRECT rectangle = {x, y, x + width, y + height};
  IDirect3DDevice9_Clear(device, 1, &rectangle, D3DCLEAR_TARGET, colour, 1, 0);
}

int main(int argc, char** argv) {
  unsigned number, frames = argc > 1 ? (unsigned)atoi(argv[1]) : 100;
  WNDCLASSA windows = {0};
  windows.lpfnWndProc = DefWindowProcA, windows.lpszClassName = "bars", windows.hInstance = GetModuleHandleA(NULL);
  RegisterClassA(&windows);
  HWND window = CreateWindowA("bars", "bars", WS_POPUP | WS_VISIBLE, 0, 0, kWidth, kHeight, NULL, NULL, windows.hInstance, NULL);
  IDirect3D9* d3d = Direct3DCreate9(D3D_SDK_VERSION);
  if (window == NULL || d3d == NULL) return 2;
  D3DPRESENT_PARAMETERS how = {0};
  how.Windowed = TRUE, how.SwapEffect = D3DSWAPEFFECT_DISCARD, how.hDeviceWindow = window;
  how.BackBufferFormat = D3DFMT_X8R8G8B8, how.BackBufferWidth = kWidth, how.BackBufferHeight = kHeight;
  how.PresentationInterval = D3DPRESENT_INTERVAL_IMMEDIATE;
  IDirect3DDevice9* device = NULL;
  if (FAILED(IDirect3D9_CreateDevice(d3d, D3DADAPTER_DEFAULT, D3DDEVTYPE_HAL, window, D3DCREATE_HARDWARE_VERTEXPROCESSING,
                                     &how, &device)))
    return 2;
  for (number = 1; number <= frames; ++number) {
    int half, i, bar = kWidth / kBars;
    MSG message;
    while (PeekMessageA(&message, NULL, 0, 0, PM_REMOVE)) DispatchMessageA(&message);
    fill(device, 0, 0, kWidth, kHeight, D3DCOLOR_XRGB(0, 0, 0));
    for (half = 0; half < 2; ++half)
      for (i = 0; i < kBars; ++i) {
        int value = (number >> (kBars - 1 - i)) & 1 ? 255 : 128;
        fill(device, i * bar + bar / 4, half * (kHeight / 2), bar / 2, kHeight / 2, D3DCOLOR_XRGB(value, value, value));
      }
    fill(device, 0, 0, kWidth, kBorder, D3DCOLOR_XRGB(255, 0, 0));
    IDirect3DDevice9_Present(device, NULL, NULL, NULL, NULL);
    printf("swap %u\n", number);
    fflush(stdout);
    Sleep(16);
  }
  return 0;
}
