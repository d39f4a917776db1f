(* Theorem 2.2 for a polytope of pencils: blocks of every pair of vertices that are
   positive definite put the poles of every mean of the vertices into the region. *)
From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra ssrZ zify ring.
From formal Require Export integers definite.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* A vertex: E and A of the pencil s E - A, and their products with P. *)
Record vertex := Vertex { vE : entries; vA : entries; vEP : entries; vAP : entries }.
Definition vertex_of N P (E A : entries) : vertex :=
  Vertex E A (memo N N (mul N E P)) (memo N N (mul N A P)).

Definition both N (f g : vertex -> entries) (i j : vertex) : entries :=
  memo N N (fun r c => Z.add (mul N (f i) (tr (g j)) r c) (mul N (f j) (tr (g i)) r c)).

(* Minus twice the symmetric part of the theorem's matrix, for two vertices. *)
Definition block N k (alpha beta : entries) (i j : vertex) : entries :=
  let ee := both N vEP vE i j in
  let ae := both N vAP vE i j in
  let ea := both N vEP vA i j in
  memo (k * N) (k * N) (fun I J =>
    let a := (I %/ N)%N in let r := (I %% N)%N in
    let b := (J %/ N)%N in let c := (J %% N)%N in
    Z.opp (Z.add (Z.mul (alpha a b) (ee r c))
      (Z.add (Z.mul (beta a b) (ae r c)) (Z.mul (beta b a) (ea r c))))).

(* What shows that a matrix is definite: u, t and L of definite.v. *)
Definition witness := (Z * Z * seq (seq Z))%type.
Definition shown n (w : witness) (G : entries) := definite n w.1.1 w.1.2 (at_ w.2) G.

Definition no_witness : witness := (Z0, Z0, [::]).
Definition no_vertex := Vertex (at_ [::]) (at_ [::]) (at_ [::]) (at_ [::]).
Definition lmis_hold N k (alpha beta P : entries) (pencils : seq (entries * entries))
    (wP : witness) (wG : seq (seq witness)) : bool :=
  let r := size pencils in
  let vs := [seq vertex_of N P p.1 p.2 | p <- pencils] in
  if shown N wP P then
    below r (fun i => below r (fun j => if (i <= j)%N then
      shown (k * N) (nth no_witness (nth [::] wG i) (j - i))
        (block N k alpha beta (nth no_vertex vs i) (nth no_vertex vs j))
      else true))
  else false.

Section Meaning.
Variable C : numClosedFieldType.

Definition adj n m (x : 'M[C]_(n, m)) : 'M[C]_(m, n) := (map_mx conjC x)^T.
Definition sesqui n (A : 'M[C]_n) (x y : 'rV[C]_n) : C := (x *m A *m adj y) 0 0.
Definition herm n (A : 'M[C]_n) (x : 'rV[C]_n) : C := sesqui A x x.

(* s lies in the region alpha + beta s + beta' s* < 0. *)
Definition in_region k (alpha beta : 'M[C]_k) (s : C) : Prop :=
  forall v : 'rV[C]_k, v != 0 -> herm (alpha + s *: beta + s^* *: beta^T) v < 0.

Lemma sesquiDl n (A : 'M[C]_n) x y z : sesqui A (x + y) z = sesqui A x z + sesqui A y z.
Proof. by rewrite /sesqui mulmxDl mulmxDl mxE. Qed.
Lemma sesquiZl n (A : 'M[C]_n) a x y : sesqui A (a *: x) y = a * sesqui A x y.
Proof. by rewrite /sesqui -scalemxAl -scalemxAl mxE. Qed.
Lemma sesqui0l n (A : 'M[C]_n) y : sesqui A 0 y = 0.
Proof. by rewrite /sesqui !mul0mx mxE. Qed.
Lemma sesquiDr n (A : 'M[C]_n) x y z : sesqui A x (y + z) = sesqui A x y + sesqui A x z.
Proof. by rewrite /sesqui /adj map_mxD [(_ + _)^T]raddfD mulmxDr mxE. Qed.
Lemma sesquiZr n (A : 'M[C]_n) a x y : sesqui A x (a *: y) = a^* * sesqui A x y.
Proof. by rewrite /sesqui /adj map_mxZ [(_ *: _)^T]linearZ -scalemxAr mxE. Qed.
Lemma sesqui0r n (A : 'M[C]_n) y : sesqui A y 0 = 0.
Proof. by rewrite -(scale0r 0) sesquiZr conjC0 mul0r. Qed.
Lemma sesqui_sumr n (A : 'M[C]_n) r x (w : 'I_r -> C) (y : 'I_r -> 'rV[C]_n) :
  sesqui A x (\sum_i w i *: y i) = \sum_i (w i)^* * sesqui A x (y i).
Proof.
rewrite (big_morph (sesqui A x) (sesquiDr A x) (sesqui0r A x)).
by apply: eq_bigr => i _; exact: sesquiZr.
Qed.
Lemma sesqui_suml n (A : 'M[C]_n) r y (w : 'I_r -> C) (x : 'I_r -> 'rV[C]_n) :
  sesqui A (\sum_i w i *: x i) y = \sum_i w i * sesqui A (x i) y.
Proof.
rewrite (big_morph (fun z => sesqui A z y) (fun z t => sesquiDl A z t y) (sesqui0l A y)).
by apply: eq_bigr => i _; exact: sesquiZl.
Qed.

(* A row as a function, and the form of definite.v. *)
Definition ext n (x : 'rV[C]_n) (i : nat) : C := if insub i is Some o then x 0 o else 0.
Lemma extE n (x : 'rV[C]_n) (i : 'I_n) : ext x i = x 0 i.
Proof. by rewrite /ext valK. Qed.
Lemma ext_nonzero n (x : 'rV[C]_n) : x != 0 -> exists2 i, (i < n)%N & ext x i != 0.
Proof. by move=> /rV0Pn[i xi]; exists i => //; rewrite extE. Qed.

Lemma form_herm n (g : entries) (x : 'rV[C]_n) :
  form n (fun i j => phi C (g i j)) (ext x) = herm (mx C n n g) x.
Proof.
rewrite /form exchange_big /herm /sesqui mxE; apply: eq_bigr => j _.
rewrite !mxE mulr_suml; apply: eq_bigr => i _.
by rewrite !mxE !extE.
Qed.

Lemma shown_sound n w G (x : 'rV[C]_n) : shown n w G -> x != 0 -> 0 < herm (mx C n n G) x.
Proof.
by move=> sh nz; rewrite -form_herm; apply: (definite_sound sh); exact: ext_nonzero.
Qed.

Lemma sum_mul k N (F : nat -> C) :
  \sum_(i < k * N) F i = \sum_(a < k) \sum_(r < N) F (a * N + r)%N.
Proof.
rewrite -(big_mkord xpredT F) big_nat_mul big_mkord; apply: eq_bigr => a _.
rewrite -{1}[(a * N)%N]add0n big_addn mulSn addnK big_mkord.
by apply: eq_bigr => r _; rewrite addnC.
Qed.

(* The row kron(v, q). *)
Definition krow N (v q : nat -> C) (i : nat) : C := v (i %/ N)%N * q (i %% N)%N.

Lemma form_kron k N (f g : nat -> nat -> C) v q : (0 < N)%N ->
  form (k * N) (fun I J => f (I %/ N)%N (J %/ N)%N * g (I %% N)%N (J %% N)%N) (krow N v q)
  = form k f v * form N g q.
Proof.
move=> N0.
pose K I J := krow N v q I * (f (I %/ N)%N (J %/ N)%N * g (I %% N)%N (J %% N)%N)
  * (krow N v q J)^*.
rewrite /form (sum_mul k N (fun I => \sum_(J < k * N) K I J)) mulr_suml.
apply: eq_bigr => a _.
transitivity (\sum_(r < N) \sum_(b < k) \sum_(c < N) K (a * N + r)%N (b * N + c)%N).
  by apply: eq_bigr => r _; exact: (sum_mul k N (K (a * N + r)%N)).
rewrite exchange_big mulr_suml; apply: eq_bigr => b _.
rewrite mulr_sumr; apply: eq_bigr => r _; rewrite mulr_sumr; apply: eq_bigr => c _.
have edge m (o : 'I_N) : ((m * N + o) %/ N = m)%N /\ ((m * N + o) %% N = o)%N.
  by rewrite divnMDl // modnMDl divn_small ?modn_small ?addn0.
rewrite /K /krow; have [-> ->] := edge a r; have [-> ->] := edge b c.
have -> : (v b * q c)^* = (v b)^* * (q c)^* by exact: rmorphM.
ring.
Qed.

Lemma krow_nonzero k N (v : 'rV[C]_k) (q : 'rV[C]_N) : v != 0 -> q != 0 ->
  exists2 i, (i < k * N)%N & krow N (ext v) (ext q) i != 0.
Proof.
move=> /rV0Pn[a va] /rV0Pn[r qr]; exists (a * N + r)%N.
  by rewrite (leq_trans (_ : _ < a * N + N)%N) ?ltn_add2l // -mulSnr leq_mul2r orbC ltn_ord.
have N0 : (0 < N)%N by case: (N) (r) => [[]|].
rewrite /krow divnMDl // modnMDl divn_small ?modn_small ?addn0 //.
by rewrite !extE mulf_neq0.
Qed.

Lemma eq_form n (g h : nat -> nat -> C) x :
  (forall i j, (i < n)%N -> (j < n)%N -> g i j = h i j) -> form n g x = form n h x.
Proof.
by move=> e; apply: eq_bigr => i _; apply: eq_bigr => j _; rewrite e.
Qed.
Lemma formD n (g h : nat -> nat -> C) x :
  form n (fun i j => g i j + h i j) x = form n g x + form n h x.
Proof.
rewrite /form -big_split; apply: eq_bigr => i _; rewrite -big_split.
by apply: eq_bigr => j _ /=; rewrite mulrDr mulrDl.
Qed.
Lemma formN n (g : nat -> nat -> C) x : form n (fun i j => - g i j) x = - form n g x.
Proof.
rewrite /form -sumrN; apply: eq_bigr => i _; rewrite -sumrN.
by apply: eq_bigr => j _ /=; rewrite mulrN mulNr.
Qed.

Lemma block_form N k alpha beta i j (v : 'rV[C]_k) (q : 'rV[C]_N) : (0 < N)%N ->
  form (k * N) (fun I J => phi C (block N k alpha beta i j I J)) (krow N (ext v) (ext q))
  = - (herm (mx C k k alpha) v * herm (mx C N N (both N vEP vE i j)) q
       + (herm (mx C k k beta) v * herm (mx C N N (both N vAP vE i j)) q
          + herm (mx C k k (tr beta)) v * herm (mx C N N (both N vEP vA i j)) q)).
Proof.
move=> N0; rewrite -!form_herm -!form_kron // -!formD -formN.
by apply: eq_form => I J hI hJ; rewrite /block memoE // phiN !phiD !phiM.
Qed.

Lemma both_herm N (f g : vertex -> entries) i j (q : 'rV[C]_N) :
  herm (mx C N N (both N f g i j)) q
  = herm (mx C N N (f i) *m (mx C N N (g j))^T) q
    + herm (mx C N N (f j) *m (mx C N N (g i))^T) q.
Proof.
have -> : mx C N N (both N f g i j)
    = mx C N N (f i) *m (mx C N N (g j))^T + mx C N N (f j) *m (mx C N N (g i))^T.
  rewrite /both mx_memo -!mx_tr -!mx_mul.
  by apply/matrixP => r c; rewrite !mxE phiD.
by rewrite /herm /sesqui mulmxDr mulmxDl mxE.
Qed.

Lemma adj_real N n (g : entries) (q : 'rV[C]_N) :
  adj (q *m mx C N n g) = (mx C N n g)^T *m adj q.
Proof.
rewrite /adj map_mxM trmx_mul; congr (_^T *m _).
by apply/matrixP => r c; rewrite !mxE phi_conj.
Qed.

Lemma sandwich N (g h : entries) (P : 'M[C]_N) (q : 'rV[C]_N) :
  herm (mx C N N g *m P *m (mx C N N h)^T) q
  = sesqui P (q *m mx C N N g) (q *m mx C N N h).
Proof. by rewrite /herm /sesqui adj_real !mulmxA. Qed.

Section Polytope.
Variables (N k : nat) (alpha beta P : entries) (pencils : seq (entries * entries)).
Variables (wP : witness) (wG : seq (seq witness)).
Hypothesis N_positive : (0 < N)%N.
Hypothesis holds : lmis_hold N k alpha beta P pencils wP wG.

Variable r : nat.
Hypothesis size_r : size pencils = r.
Definition E_ (i : nat) : 'M[C]_N := mx C N N (nth (at_ [::], at_ [::]) pencils i).1.
Definition A_ (i : nat) : 'M[C]_N := mx C N N (nth (at_ [::], at_ [::]) pencils i).2.
Let Pm := mx C N N P.

Definition part (v : 'rV[C]_k) (q : 'rV[C]_N) i j : C :=
  herm (mx C k k alpha) v * sesqui Pm (q *m E_ i) (q *m E_ j)
  + herm (mx C k k beta) v * sesqui Pm (q *m A_ i) (q *m E_ j)
  + herm (mx C k k beta)^T v * sesqui Pm (q *m E_ i) (q *m A_ j).

Lemma part_sum v q i j : v != 0 -> q != 0 -> (i < r)%N -> (j < r)%N ->
  part v q i j + part v q j i < 0.
Proof.
move=> v0 q0; wlog le_ij : i j / (i <= j)%N.
  move=> H hi hj; case: (leqP i j) => [le|/ltnW le]; first exact: H.
  by rewrite addrC; apply: H.
move=> hi hj; move: holds; rewrite /lmis_hold size_r; case: ifP => // _.
move=> /belowP/(_ i hi)/belowP/(_ j hj); rewrite le_ij => sh.
have := definite_sound sh (krow_nonzero v0 q0).
rewrite block_form // oppr_gt0 !both_herm.
rewrite !(nth_map (at_ [::], at_ [::])) ?size_r //= !mx_memo !mx_mul mx_tr.
congr (_ < 0).
by rewrite !sandwich -!/(E_ _) -!/(A_ _) -/Pm /part; ring.
Qed.
Variable w : 'I_r -> C.
Hypothesis w_ge0 : forall i, 0 <= w i.
Hypothesis w_sum : \sum_i w i = 1.
Definition E_mean : 'M[C]_N := \sum_i w i *: E_ i.
Definition A_mean : 'M[C]_N := \sum_i w i *: A_ i.

Lemma mean_negative v q : v != 0 -> q != 0 ->
  herm (mx C k k alpha) v * sesqui Pm (q *m E_mean) (q *m E_mean)
  + herm (mx C k k beta) v * sesqui Pm (q *m A_mean) (q *m E_mean)
  + herm (mx C k k beta)^T v * sesqui Pm (q *m E_mean) (q *m A_mean) < 0.
Proof.
move=> v0 q0; have conj_w i : (w i)^* = w i by rewrite conj_Creal ?ger0_real.
have dist (X : 'I_r -> 'M[C]_N) : q *m (\sum_i w i *: X i) = \sum_i w i *: (q *m X i).
  by rewrite mulmx_sumr; apply: eq_bigr => i _; rewrite scalemxAr.
have two (x y : 'I_r -> 'rV[C]_N) : sesqui Pm (\sum_i w i *: x i) (\sum_i w i *: y i)
    = \sum_i \sum_j w i * w j * sesqui Pm (x i) (y j).
  rewrite sesqui_suml; apply: eq_bigr => i _; rewrite sesqui_sumr mulr_sumr.
  by apply: eq_bigr => j _; rewrite conj_w mulrA.
rewrite /E_mean /A_mean !dist !two; set S := (X in X < 0).
have -> : S = \sum_(i < r) \sum_(j < r) w i * w j * part v q i j.
  rewrite /S !mulr_sumr -!big_split; apply: eq_bigr => i _.
  by rewrite !mulr_sumr -!big_split; apply: eq_bigr => j _; rewrite /part /=; ring.
set T := \sum_(i < _) _; rewrite -(pmulrn_llt0 _ (ltn0Sn 1)).
have -> : T *+ 2 = \sum_(i < r) \sum_(j < r) w i * w j * (part v q i j + part v q j i).
  rewrite mulr2n {2}/T exchange_big -big_split; apply: eq_bigr => i _.
  by rewrite -big_split; apply: eq_bigr => j _ /=; ring.
have neg i j : w i * w j * (part v q i j + part v q j i) <= 0.
  by rewrite mulr_ge0_le0 ?mulr_ge0 // ltW // part_sum.
have /existsP[i wi] : [exists i, w i != 0].
  apply/contraT => /existsPn all0; move: w_sum; rewrite big1 => [/eqP|i _].
    by rewrite eq_sym oner_eq0.
  by apply/eqP; have := all0 i; rewrite negbK.
have wi0 : 0 < w i by rewrite lt_def wi w_ge0.
rewrite -oppr_gt0 -sumrN (bigD1 i) //=; apply: ltr_paddr.
  by apply: sumr_ge0 => j _; rewrite oppr_ge0 -oppr_ge0 -sumrN sumr_ge0 // => l _;
     rewrite oppr_ge0.
rewrite -sumrN (bigD1 i) //=; apply: ltr_paddr.
  by apply: sumr_ge0 => j _; rewrite oppr_ge0.
by rewrite oppr_gt0 pmulr_rlt0 ?mulr_gt0 // part_sum.
Qed.

(* No plant of the polytope has a singular E, *)
Theorem E_regular : (0 < k)%N -> \det E_mean != 0.
Proof.
move=> k0; apply/det0P => -[q q0 qE].
have v0 : const_mx 1 != 0 :> 'rV[C]_k.
  by apply/rV0Pn; exists (Ordinal k0); rewrite mxE oner_neq0.
have := mean_negative v0 q0.
by rewrite qE !sesqui0l !sesqui0r !mulr0 !addr0 ltxx.
Qed.

(* and all its poles lie in the region. *)
Theorem poles_in_region s : \det (s *: E_mean - A_mean) = 0 ->
  in_region (mx C k k alpha) (mx C k k beta) s.
Proof.
move=> /eqP/det0P[q q0 /eqP]; rewrite mulmxBr subr_eq0 -scalemxAr eq_sym => /eqP qA v v0.
have := mean_negative v0 q0; rewrite qA sesquiZl sesquiZr.
set p := sesqui Pm _ _ => neg.
have -> : herm (mx C k k alpha + s *: mx C k k beta + s^* *: (mx C k k beta)^T) v
  = herm (mx C k k alpha) v + s * herm (mx C k k beta) v
    + s^* * herm (mx C k k beta)^T v.
  by rewrite /herm /sesqui !mulmxDr !mulmxDl -!scalemxAr -!scalemxAl !mxE.
have p0 : 0 <= p.
  rewrite /p; have [->|nz] := eqVneq (q *m E_mean) 0; first by rewrite sesqui0l.
  move: holds; rewrite /lmis_hold; case: ifP => // sh _.
  by apply: ltW; exact: shown_sound sh nz.
have {}neg : (herm (mx C k k alpha) v + s * herm (mx C k k beta) v
    + s^* * herm (mx C k k beta)^T v) * p < 0.
  by rewrite (_ : _ * p = herm (mx C k k alpha) v * p + herm (mx C k k beta) v * (s * p)
     + herm (mx C k k beta)^T v * (s^* * p)) //; ring.
move: p0 neg; rewrite le_eqVlt => /orP[/eqP<-|p0]; first by rewrite mulr0 ltxx.
by rewrite pmulr_llt0.
Qed.
End Polytope.
End Meaning.
