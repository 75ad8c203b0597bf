// Vectors, paths and surfaces in the manner of the large function libraries.
_EPSILON = 1e-9;
function approx(a, b, eps=_EPSILON) = is_num(a) && is_num(b) ? abs(a - b) < eps
    : is_list(a) && is_list(b) ? len(a) == len(b) && [] == [for (i = [0:1:len(a)-1]) if (!approx(a[i], b[i], eps)) 1]
    : a == b;
function default(v, dflt) = is_undef(v) ? dflt : v;
function first_defined(v, i=0) = i < len(v) && is_undef(v[i]) ? first_defined(v, i + 1) : v[i];
function select(list, start, end) = let (l = len(list)) end == undef
    ? (is_num(start) ? list[(start % l + l) % l] : [for (i = start) list[(i % l + l) % l]])
    : let (s = (start % l + l) % l, e = (end % l + l) % l) s <= e
        ? [for (i = [s:1:e]) list[i]] : concat([for (i = [s:1:l-1]) list[i]], [for (i = [0:1:e]) list[i]]);
function idx(list, s=0, e=-1, step=1) = let (l = len(list)) [(s + l) % l : step : (e + l) % l];
function flatten(l) = [for (a = l) each a];
function reverse(l) = [for (i = [len(l)-1:-1:0]) l[i]];
function sum(v, dflt=0) = v == [] ? dflt : _sum(v, v[0] * 0);
function _sum(v, total, i=0) = i >= len(v) ? total : _sum(v, total + v[i], i + 1);
function cumsum(v) = [for (a = v[0], i = 1; i <= len(v); a = i < len(v) ? a + v[i] : a, i = i + 1) a];
function unit(v) = assert(is_list(v), str("not a vector: ", v)) let (n = norm(v)) n < _EPSILON ? v : v / n;
function deduplicate(list, closed=false, eps=_EPSILON) = let (l = len(list), end = l - (closed ? 0 : 1))
    [for (i = [0:1:l-1]) if (i == end || !approx(list[i], list[(i + 1) % l], eps)) list[i]];
function pairs(list, wrap=false) = let (n = len(list)) [for (i = [0:1:n - (wrap ? 1 : 2)]) [list[i], list[(i + 1) % n]]];
function path_length(p, closed=false) = sum([for (e = pairs(p, closed)) norm(e[1] - e[0])]);
function rot2(a) = [[cos(a), -sin(a)], [sin(a), cos(a)]];
function apply(m, pts) = [for (p = pts) m * p];
function sort(l) = len(l) <= 1 ? l
    : let (p = l[len(l) / 2], a = [for (x = l) if (x < p) x], b = [for (x = l) if (x == p) x], c = [for (x = l) if (x > p) x])
      concat(sort(a), b, sort(c));
function bezier(c, t) = len(c) == 1 ? c[0]
    : bezier([for (i = [0:1:len(c)-2]) c[i] * (1 - t) + c[i+1] * t], t);
function vnf_grid(rows) = let (n = len(rows), m = len(rows[0]))
    [flatten(rows), [for (i = [0:n-2], j = [0:m-2]) let (a = i * m + j) each [[a, a + 1, a + m], [a + 1, a + m + 1, a + m]]]];
function vnf_volume(vnf) = sum([for (f = vnf[1]) cross(vnf[0][f[2]], vnf[0][f[1]]) * vnf[0][f[0]]]) / 6;
map = function (f, l) [for (x = l) f(x)];
filter = function (f, l) [for (x = l) if (f(x)) x];
reduce = function (f, l, init) len(l) == 0 ? init : reduce(f, select(l, 1, -1), f(init, l[0])) ;
fold = function (f, l, acc, i=0) i >= len(l) ? acc : fold(f, l, f(acc, l[i]), i + 1);
compose = function (f, g) function (x) f(g(x));
adders = [for (n = [1:3]) let (twice = 2 * n) function (x) x + twice];

square_path = [[0, 0], [4, 0], [4, 3], [0, 3], [0, 3]];
echo(dedup = deduplicate(square_path), length = path_length(deduplicate(square_path), closed=true));
echo(select(square_path, -1), select(square_path, 3, 1), [for (i = idx(square_path)) i]);
echo(sum([[1, 2], [3, 4]]), sum([]), cumsum([1, 2, 3, 4]), reverse("abc"), unit([3, 4]));
echo(apply(rot2(90), square_path), approx(rot2(45) * rot2(-45), [[1, 0], [0, 1]]));
echo(sort([5, 2, 9, 2, 7, 1]), [for (t = [0:0.25:1]) bezier([[0, 0], [1, 2], [3, 2], [4, 0]], t)]);
cube_vnf = [[for (z = [0, 2], y = [0, 2], x = [0, 2]) [x, y, z]],
            [[0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4], [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5]]];
echo(vnf_volume(cube_vnf), len(vnf_grid([for (i = [0:3]) [for (j = [0:4]) [i, j, i * j]]])[1]));
echo(map(function (x) x * x, [1, 2, 3]), filter(function (x) x % 2 == 0, [for (i = [1:9]) i]));
echo(fold(function (a, b) a + b, [1, 2, 3, 4], 0), compose(adders[0], adders[2])(10), [for (f = adders) f(100)]);
echo(first_defined([undef, undef, 7]), default(undef, "d"), is_function(map), str(compose));
echo([for (i = [0:4]) if (i % 2 == 0) each [i, -i] else if (i == 3) "three"]);
echo(let (a = 3, b = a * a, $x = b) [for (i = [a:b]) i * $x], search("lo", "hello world"), lookup(2.5, [[0, 0], [5, 50]]));
polyhedron(cube_vnf[0], cube_vnf[1], convexity = 2);
for (p = deduplicate(square_path)) translate([p.x, p.y, sum(p)]) cube(0.5, center = true);
