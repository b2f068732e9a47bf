% How far the picture `n` has moved since `o`, in bins to the right and down, both 30 x 40; and whether anything was seen.
% Elementary motion detection, divided by the texture's gradient; the median of 12 parts of the picture, refined six times.
function [d, seen] = shift_of(o, n)
  d = [0 0]; at = @(place, size) max(0, 1 - abs(place' - (1:size)));  % between bins by linear interpolation
  part = @(A) kron(eye(3), ones(1, 8)) * A * kron(eye(4), ones(8, 1));  % sums of 8 x 8 bins
  for k = 1:6  % moves both pictures by half of the shift so far, towards each other, and adds what is left
    a = at((3:28) - d(2)/2, 30) * o * at((4:37) - d(1)/2, 40)';
    b = at((3:28) + d(2)/2, 30) * n * at((4:37) + d(1)/2, 40)';
    [ty, gy] = along(a, b); [tx, gx] = along(a', b');
    ty = part(ty(:,2:end-1)); gy = gy(:,2:end-1); tx = part(tx'(2:end-1,:)); gx = gx'(2:end-1,:);
    A = part(gx.^2); B = part(gx .* gy); C = part(gy.^2); det = A .* C - B.^2;
    seen = A + C > 340 & det > 0;  % six times what noise makes of it
    if ! any(seen(:)), d = [0 0]; break; end
    d -= 0.75 * 4 * [median(((C.*tx - B.*ty) ./ det)(seen)), median(((A.*ty - B.*tx) ./ det)(seen))];
    d = max(-3, min(3, d));
  end
  seen = any(seen(:));
end
function [t, g, M] = along(o, n)  % older and newer picture, along their columns
  M = n(1:end-1,:) .* o(2:end,:) - o(1:end-1,:) .* n(2:end,:);  % equation (2); of transposed pictures (1)
  P = n(1:end-1,:) .* n(2:end,:) - o(1:end-1,:) .* o(2:end,:);
  t = M(1:end-1,:) + M(2:end,:) + diff(P);  % (n - o) .* g
  g = (o + n)(3:end,:) - (o + n)(1:end-2,:);
end
