% Which point of the LMIs of Example 4 does LMI Lab's feasp return?
%
% The thesis used LMI Lab. This script asks it for Example 4 twice: as it comes,
% when feasp may stop at the first feasible point, and told to go on to the largest
% margin. It prints both gains beside the thesis's. It needs MATLAB with the Robust
% Control Toolbox. We have none, so MATLAB has never run it; the book's tests
% evaluate its data and LMIs elsewhere. Please send us what it prints.

M = [0.05 0; 0 0.1];
B2 = [0; 1];
U = [0 1];
stiffness = {[51 -50; -50 50], [50+2/pi -50; -50 50]};
sigma = 5; rho = 15; theta = pi/3;
s = sin(theta); c = cos(theta);
printed = [-75.7438 69.9357 3.2975 -4.1265 -13.9027];

E = blkdiag(eye(2), M, 1);
B = [zeros(2, 1); B2; 0];

setlmis([]);
P = lmivar(1, [5 1]);
Y = lmivar(2, [1 5]);
for v = 1:2
    A = [zeros(2) eye(2) zeros(2, 1); -stiffness{v} zeros(2, 3); U zeros(1, 3)];

    half = newlmi;                              % (2.18)
    lmiterm([half 1 1 P], A, E', 's');
    lmiterm([half 1 1 Y], B, E', 's');
    lmiterm([half 1 1 P], 2*sigma*E, E');

    disk = newlmi;                              % (2.19)
    lmiterm([disk 1 1 P], -rho*E, E');
    lmiterm([disk 2 2 P], -rho*E, E');
    lmiterm([disk 1 2 P], A, E');
    lmiterm([disk 1 2 Y], B, E');

    sector = newlmi;                            % (2.20)
    lmiterm([sector 1 1 P], s*A, E', 's');
    lmiterm([sector 1 1 Y], s*B, E', 's');
    lmiterm([sector 2 2 P], s*A, E', 's');
    lmiterm([sector 2 2 Y], s*B, E', 's');
    lmiterm([sector 1 2 P], c*A, E');
    lmiterm([sector 1 2 P], -c*E, A');
    lmiterm([sector 1 2 Y], c*B, E');
    lmiterm([sector 1 2 -Y], -c*E, B');
end
positive = newlmi;
lmiterm([-positive 1 1 P], 1, 1);
lmis = getlmis;

names = {'first feasible point', 'largest margin'};
targets = [0 -1e9];
for k = 1:2
    [t, x] = feasp(lmis, [0 0 0 0 0], targets(k));
    K = dec2mat(lmis, x, Y) / dec2mat(lmis, x, P);
    fprintf('%s: t = %.4g\n', names{k}, t);
    fprintf('%10.4f', K);
    fprintf('\nlargest difference from the thesis: %.2f %%\n', ...
            100 * max(abs(K ./ printed - 1)));
end
